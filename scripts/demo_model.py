#!/usr/bin/env python3
"""Writes the demo building: a small two-storey office in IFC4, the model that groundplan's tests and demo run on.

    python3 scripts/demo_model.py config/demo/demo.ifc     write the model
    python3 scripts/demo_model.py --cabinet FILE.ifc       the same with a cabinet where the leaf of a door swings
    python3 scripts/demo_model.py --facts                  print the figures that tests need, as JSON, in metres

What the building exercises:

- units: millimetres and degrees, a true north and a map conversion that must not turn the map;
- floors: a bathroom 30 mm up on a covering, a loading dock 250 mm down behind a ramp, a slab with holes for stair, lift
  and atrium, spaces that are no floor (`U.11 Atrium void`, the part of `U.08` above the stair), terrain on the site;
- doors: hinged left and right, one mirrored by its mapped item, double, sliding, folding, rolling up, one of 0.70 m that a
  robot cannot pass, one to the outside without floor beyond, lift doors, an opening without door; a `Clearance`
  body and a `FootPrint` curve that must not be drawn; linings, panels and operation on the types;
- obstacles of every class: layered walls with `Axis` curves, columns, a beam and a duct overhead, windows, two glazed
  walls made of parts, a stair of parts, railings, a parapet, furniture, a boiler, a lift car; a virtual element that is none;
- spaces: an L-shaped corridor, centres blocked by a column and by tables, a room to be closed by configuration,
  first-level boundaries, names with an umlaut and with an apostrophe;
- a schedule from March to June 2024: a calendar with a holiday, tasks in three phases with written and computed dates,
  both ways of linking products, tasks on rooms, dates in property sets, elements without any date; on elements and rooms the
  number of their activity as a property, for the same schedule as a file of a planner's tool (scripts/demo_schedule.py).

All lengths are millimetres. Plans are in building coordinates, x to the east, y to the north; heights are above the storey's
finished floor. Everything with a key starting with `G` is on the ground floor, with `U` on the upper floor.
The same script gives the same bytes: GlobalIds are hashes of keys, time stamps are fixed.
"""
import argparse
import json
import math
import uuid
from collections import defaultdict
from typing import NamedTuple

import ifcopenshell
import ifcopenshell.guid

# ------------------------------------------------------------------ the building as data


class Rect(NamedTuple):
    x0: int
    y0: int
    x1: int
    y1: int

    @property
    def corners(self):
        return [(self.x0, self.y0), (self.x1, self.y0), (self.x1, self.y1), (self.x0, self.y1)]

    @property
    def size(self):
        return self.x1 - self.x0, self.y1 - self.y0


class Storey(NamedTuple):
    name: str
    floor: int


class Room(NamedTuple):
    long_name: str
    corners: list
    base: int = 0
    top: int = 2800
    ready: str = None                 # RoomDate


class Wall(NamedTuple):
    kind: str
    rect: Rect
    base: int = 0
    top: int = 2800


class Door(NamedTuple):
    wall: str
    centre: int                       # along the wall, in building coordinates
    width: int
    operation: str                    # as the type says, seen in the type's own frame
    faces: str                        # where the leaf swings to: N, E, S or W
    hung: str                         # DoorDate
    height: int = 2100
    sill: int = 0
    mirrored: bool = False            # the type's shape is mapped with x reversed: left becomes right


class Box(NamedTuple):
    x: float
    y: float
    z: float
    dx: float
    dy: float
    dz: float
    glass: bool = False


STOREYS = {'G': Storey('Ground floor', 0), 'U': Storey('Upper floor', 3200)}
CLEAR_HEIGHT = 2800
UPPER_SLAB, ROOF_SLAB, GROUND_SLAB = 400, 300, 300

OUTLINE = Rect(0, 0, 24000, 15000)
STAIR = Rect(12420, 7600, 13620, 12360)              # climbs to the north
RISERS, TREAD, WAIST = 18, 280, 200
STAIR_HOLE = Rect(12420, 7900, 13680, 12360)
ATRIUM = Rect(18650, 300, 23850, 8500)
SHAFT = Rect(14930, 12700, 16730, 14700)
BATHROOM = Rect(14400, 300, 16730, 4800)
BATHROOM_FLOORING = 30
DOCK = Rect(300, 300, 4800, 4800)
DOCK_LEVEL = -250
RAMP = Rect(500, 2000, 1900, 4800)                   # falls to the south, 0.089 rad

LANDING_PLAN = [(12420, 6840), (16730, 6840), (16730, 12550), (14780, 12550), (14780, 14700), (12420, 14700)]

ROOMS = {
    'G.01': Room('Loading dock', DOCK.corners, base=DOCK_LEVEL),
    'G.02': Room('Plant room', Rect(4920, 300, 7800, 4800).corners, ready='31/05/2024'),
    'G.03': Room('Server room', Rect(7920, 300, 10380, 4800).corners, ready='31/05/2024'),
    'G.04': Room('Küche', Rect(10500, 300, 14300, 4800).corners, ready='31/05/2024'),
    'G.05': Room('Bathroom', BATHROOM.corners, base=BATHROOM_FLOORING, ready='31/05/2024'),
    'G.06': Room('Corridor', [(300, 4920), (16730, 4920), (16730, 6720), (2100, 6720), (2100, 14700), (300, 14700)]),
    'G.07': Room('Office', Rect(2220, 6840, 8000, 9980).corners, ready='31/05/2024'),
    'G.08': Room('Meeting room', Rect(2220, 10100, 6200, 14700).corners, ready='31/05/2024'),
    'G.09': Room('Store', Rect(6300, 10100, 8000, 14700).corners, ready='31/05/2024'),
    'G.10': Room('Open-plan office', Rect(8120, 6840, 12300, 14700).corners, ready='31/05/2024'),
    'G.11': Room('Stair hall', LANDING_PLAN),
    'G.12': Room('Lift shaft', SHAFT.corners, top=6000),
    'G.13': Room('Foyer', [(16850, 300), (18650, 300), (18650, 8500), (23700, 8500), (23700, 10500), (16850, 10500)]),
    'G.14': Room('Atrium', ATRIUM.corners, top=6000),
    'G.15': Room("Director's office", Rect(16850, 10620, 23700, 14700).corners, ready='31/05/2024'),
    'U.01': Room('Drawing office', Rect(300, 300, 7800, 4800).corners, ready='14/06/2024'),
    'U.02': Room('Archive', Rect(7920, 300, 12300, 4800).corners, ready='14/06/2024'),
    'U.03': Room('Laboratory', Rect(12420, 300, 16730, 4800).corners, ready='14/06/2024'),
    'U.04': Room('Upper corridor', Rect(300, 4920, 16730, 6720).corners),
    'U.05': Room('Office 1', Rect(300, 6840, 4200, 14700).corners, ready='14/06/2024'),
    'U.06': Room('Office 2', Rect(4320, 6840, 8220, 14700).corners, ready='14/06/2024'),
    'U.07': Room('Quiet room', Rect(8340, 6840, 12300, 14700).corners, ready='14/06/2024'),
    'U.08': Room('Upper landing', LANDING_PLAN),
    'U.09': Room('Gallery', [(16850, 300), (18590, 300), (18590, 8620), (23700, 8620), (23700, 10500), (16850, 10500)]),
    'U.10': Room('Board room', Rect(16850, 10620, 23700, 14700).corners, ready='14/06/2024'),
    'U.11': Room('Atrium void', ATRIUM.corners),
}

WALLS = {
    'G.dock-south': Wall('exterior', Rect(0, 0, 4800, 300), base=DOCK_LEVEL),
    'G.dock-west': Wall('exterior', Rect(0, 300, 300, 4800), base=DOCK_LEVEL),
    'G.south': Wall('exterior', Rect(4800, 0, 24000, 300)),
    'G.west': Wall('exterior', Rect(0, 4800, 300, 14700)),
    'G.north': Wall('exterior', Rect(0, 14700, 24000, 15000)),
    'G.east': Wall('exterior', Rect(23700, 8500, 24000, 14700)),
    'G.row-south': Wall('partition', Rect(300, 4800, 16730, 4920)),
    'G.dock-plant': Wall('partition', Rect(4800, 300, 4920, 4800)),
    'G.plant-server': Wall('partition', Rect(7800, 300, 7920, 4800)),
    'G.server-kitchen': Wall('partition', Rect(10380, 300, 10500, 4800)),
    'G.kitchen-bathroom': Wall('partition', Rect(14300, 300, 14400, 4800)),
    'G.foyer-west': Wall('partition', Rect(16730, 300, 16850, 14700)),
    'G.row-north': Wall('partition', Rect(2100, 6720, 16730, 6840)),
    'G.corridor-east': Wall('partition', Rect(2100, 6840, 2220, 14700)),
    'G.office-meeting': Wall('partition', Rect(2220, 9980, 8000, 10100)),
    'G.meeting-store': Wall('partition', Rect(6200, 10100, 6300, 14700)),
    'G.open-west': Wall('partition', Rect(8000, 6840, 8120, 14700)),
    'G.hall-west': Wall('partition', Rect(12300, 6840, 12420, 14700)),
    'G.foyer-north': Wall('partition', Rect(16850, 10500, 23700, 10620)),
    'G.lift-south': Wall('shaft', Rect(14780, 12550, 16730, 12700)),
    'G.lift-west': Wall('shaft', Rect(14780, 12700, 14930, 14700)),
    'U.south': Wall('exterior', Rect(0, 0, 24000, 300)),
    'U.west': Wall('exterior', Rect(0, 300, 300, 14700)),
    'U.north': Wall('exterior', Rect(0, 14700, 24000, 15000)),
    'U.east': Wall('exterior', Rect(23700, 8500, 24000, 14700)),
    'U.row-south': Wall('partition', Rect(300, 4800, 16730, 4920)),
    'U.drawing-archive': Wall('partition', Rect(7800, 300, 7920, 4800)),
    'U.archive-laboratory': Wall('partition', Rect(12300, 300, 12420, 4800)),
    'U.gallery-west': Wall('partition', Rect(16730, 300, 16850, 14700)),
    'U.row-north': Wall('partition', Rect(300, 6720, 16730, 6840)),
    'U.office-1-2': Wall('partition', Rect(4200, 6840, 4320, 14700)),
    'U.office-quiet': Wall('partition', Rect(8220, 6840, 8340, 14700)),
    'U.hall-west': Wall('partition', Rect(12300, 6840, 12420, 14700)),
    'U.gallery-north': Wall('partition', Rect(16850, 10500, 23700, 10620)),
    'U.lift-south': Wall('shaft', Rect(14780, 12550, 16730, 12700)),
    'U.lift-west': Wall('shaft', Rect(14780, 12700, 14930, 14700)),
    'U.parapet': Wall('parapet', Rect(18590, 8500, 23700, 8620), top=1100),
}
WALL_LAYERS = [('Render', 15), ('Insulation', 120), ('Brick', 150), ('Plaster', 15)]
WALL_MATERIALS = {'partition': 'Gypsum board', 'shaft': 'Concrete', 'parapet': 'Concrete'}
WALL_DATES = {'G partition walls': '17/04/2024', 'U partition walls': '24/04/2024',
              'G shaft walls': '19/04/2024', 'U shaft walls': '19/04/2024'}      # the shaft's walls have no task

DOORS = {
    'G.D01 main entrance': Door('G.south', 17750, 1600, 'DOUBLE_DOOR_SINGLE_SWING', 'N', hung='17/05/2024'),
    'G.D02 dock gate': Door('G.dock-west', 2550, 2400, 'ROLLINGUP', 'E', height=2300, sill=DOCK_LEVEL, hung='17/05/2024'),
    'G.D03 dock': Door('G.row-south', 1200, 1000, 'SINGLE_SWING_LEFT', 'N', hung='17/05/2024'),
    'G.D04 plant room': Door('G.row-south', 6360, 900, 'SINGLE_SWING_LEFT', 'S', mirrored=True, hung='17/05/2024'),
    'G.D05 server room': Door('G.row-south', 9150, 900, 'SINGLE_SWING_LEFT', 'S', hung='17/05/2024'),
    'G.D06 kitchen': Door('G.row-south', 12400, 1000, 'SLIDING_TO_LEFT', 'S', hung='17/05/2024'),
    'G.D07 bathroom': Door('G.row-south', 15500, 900, 'SINGLE_SWING_RIGHT', 'N', hung='17/05/2024'),
    'G.D08 office': Door('G.row-north', 5000, 900, 'SINGLE_SWING_LEFT', 'N', hung='17/05/2024'),
    'G.D09 meeting room': Door('G.corridor-east', 12900, 900, 'SINGLE_SWING_RIGHT', 'E', hung='17/05/2024'),
    'G.D10 open-plan office': Door('G.row-north', 9000, 1000, 'SINGLE_SWING_LEFT', 'N', hung='17/05/2024'),
    'G.D11 store': Door('G.open-west', 12000, 700, 'SINGLE_SWING_LEFT', 'E', hung='17/05/2024'),
    'G.D12 foyer': Door('G.foyer-west', 5820, 1600, 'DOUBLE_DOOR_SINGLE_SWING', 'E', hung='17/05/2024'),
    'G.D13 fire exit': Door('G.north', 1200, 1000, 'SINGLE_SWING_RIGHT', 'N', hung='17/05/2024'),
    "G.D14 director's office": Door('G.foyer-north', 20000, 900, 'SINGLE_SWING_RIGHT', 'N', hung='17/05/2024'),
    'G.D15 lift': Door('G.lift-south', 15830, 900, 'DOUBLE_DOOR_SLIDING', 'S', hung='31/05/2024'),
    'U.D01 drawing office': Door('U.row-south', 4000, 900, 'SINGLE_SWING_LEFT', 'S', hung='24/05/2024'),
    'U.D02 archive': Door('U.row-south', 10000, 900, 'SINGLE_SWING_RIGHT', 'S', hung='24/05/2024'),
    'U.D03 laboratory': Door('U.row-south', 14500, 1000, 'SLIDING_TO_RIGHT', 'S', hung='24/05/2024'),
    'U.D04 office 1': Door('U.row-north', 2200, 900, 'SINGLE_SWING_LEFT', 'N', hung='24/05/2024'),
    'U.D05 office 2': Door('U.row-north', 6200, 900, 'SINGLE_SWING_RIGHT', 'N', hung='24/05/2024'),
    'U.D06 quiet room': Door('U.row-north', 10300, 900, 'SINGLE_SWING_LEFT', 'N', hung='24/05/2024'),
    'U.D07 gallery': Door('U.gallery-west', 5820, 1600, 'DOUBLE_DOOR_SINGLE_SWING', 'E', hung='24/05/2024'),
    'U.D08 board room': Door('U.gallery-north', 17700, 900, 'SINGLE_SWING_LEFT', 'N', hung='24/05/2024'),
    'U.D09 board room, folding': Door('U.gallery-north', 21300, 2400, 'FOLDING_TO_LEFT', 'N', hung='24/05/2024'),
    'U.D10 lift': Door('U.lift-south', 15830, 900, 'DOUBLE_DOOR_SLIDING', 'S', hung='31/05/2024'),
}
LINING, LEAF, LINING_DEPTH = 50, 40, 100
DOOR_WITH_CLEARANCE = 'G.D10 open-plan office'
DOOR_WITH_FOOTPRINT = 'G.D08 office'
GLAZED_DOORS = ('G.D01 main entrance', 'G.D12 foyer', 'U.D07 gallery')
DOORS_WITHOUT_TASK = ('G.D15 lift', 'U.D10 lift')
# Panel operation, and position of each panel, by the type's operation.
PANELS = {
    'SINGLE_SWING_LEFT': ('SWINGING', ['LEFT']),
    'SINGLE_SWING_RIGHT': ('SWINGING', ['RIGHT']),
    'DOUBLE_DOOR_SINGLE_SWING': ('SWINGING', ['LEFT', 'RIGHT']),
    'DOUBLE_DOOR_SLIDING': ('SLIDING', ['LEFT', 'RIGHT']),
    'SLIDING_TO_LEFT': ('SLIDING', ['LEFT']),
    'SLIDING_TO_RIGHT': ('SLIDING', ['RIGHT']),
    'FOLDING_TO_LEFT': ('FOLDING', ['LEFT']),
    'ROLLINGUP': ('ROLLINGUP', ['MIDDLE']),
}

# Openings that nothing fills: wall, centre along it, width, height.
CASED_OPENINGS = {
    'G.O01 stair hall': ('G.row-north', 14800, 1400, 2300),
    'U.O01 upper landing': ('U.row-north', 14800, 1400, 2300),
}

SILL, WINDOW_HEIGHT = 900, 1400
# Wall, width, centres along it.
WINDOWS = [
    ('G.south', 1500, [6300, 11600, 13300]),
    ('G.south', 600, [15500]),
    ('G.west', 1200, [5820, 9000, 12000]),
    ('G.north', 1800, [4200, 9300, 11300, 18500, 21500]),
    ('G.east', 1500, [9500, 12600]),
    ('U.south', 1800, [2000, 4200, 6400, 10100, 13600, 15600]),
    ('U.west', 1200, [2500, 5820, 9000, 12500]),
    ('U.north', 1800, [2200, 6200, 10300, 18500, 21500]),
    ('U.east', 1500, [9500, 12600]),
]

# Outline, height of the top above the floor, thickness, predefined type.
SLABS = {
    'G.slab': ([(4800, 0), (24000, 0), (24000, 15000), (0, 15000), (0, 4800), (4800, 4800)], 0, GROUND_SLAB, 'BASESLAB'),
    'G.dock slab': (Rect(0, 0, 4800, 4800).corners, DOCK_LEVEL, GROUND_SLAB, 'BASESLAB'),
    'G.entrance landing': (Rect(16850, -1800, 18650, 0).corners, -20, 200, 'LANDING'),
    'U.slab': (OUTLINE.corners, 0, UPPER_SLAB, 'FLOOR'),
    'U.roof': (OUTLINE.corners, CLEAR_HEIGHT + ROOF_SLAB, ROOF_SLAB, 'ROOF'),
}
SLAB_HOLES = {'U.stair hole': STAIR_HOLE, 'U.atrium hole': ATRIUM, 'U.shaft hole': SHAFT}

# Centre, size (a diameter if round), height, round.
COLUMNS = {
    'G.C01 open-plan office': ((10210, 10770), 400, 2400, False),
    'G.C02 foyer': ((18480, 8680), 300, CLEAR_HEIGHT, True),
    "G.C03 director's office": ((18900, 12660), 300, CLEAR_HEIGHT, False),
    'U.C01 drawing office': ((5800, 2550), 350, CLEAR_HEIGHT, True),
}
# Plan, bottom, top.
BEAMS = {'G.B01': (Rect(10060, 6840, 10360, 14700), 2400, CLEAR_HEIGHT)}

# Plan of straight guard rails on the upper floor.
RAILINGS = {
    'U.R01 atrium': Rect(18590, 300, 18650, 8500),
    'U.R02 stair hole, east': Rect(13680, 7840, 13740, 12360),
    'U.R03 stair hole, south': Rect(12420, 7840, 13680, 7900),
}
RAILING_HEIGHT = 1100

CURTAIN_WALLS = {'G.CW atrium': Rect(23850, 300, 24000, 8500), 'U.CW atrium': Rect(23850, 300, 24000, 8500)}
CURTAIN_BAYS, MULLION, TRANSOM, PANE = 6, 40, 60, 24

# Class, predefined type, room, shape, lower left corner, size, material.
FURNISHINGS = {
    'Boiler': ('IfcBoiler', 'WATER', 'G.02', 'box', (5100, 600), (900, 700, 1700), 'Steel'),
    'WC': ('IfcSanitaryTerminal', 'TOILETPAN', 'G.05', 'box', (14900, 300), (400, 700, 420), 'Ceramic'),
    'Dock rack': ('IfcFurniture', 'SHELF', 'G.01', 'box', (4000, 400), (700, 2400, 2000), 'Steel'),
    'Server rack 1': ('IfcFurniture', 'FILECABINET', 'G.03', 'box', (8200, 1500), (600, 1000, 2000), 'Steel'),
    'Server rack 2': ('IfcFurniture', 'FILECABINET', 'G.03', 'box', (8800, 1500), (600, 1000, 2000), 'Steel'),
    'Server rack 3': ('IfcFurniture', 'FILECABINET', 'G.03', 'box', (9400, 1500), (600, 1000, 2000), 'Steel'),
    'Worktop': ('IfcFurniture', 'SHELF', 'G.04', 'box', (10500, 300), (3000, 600, 880), 'Timber'),
    'Kitchen table': ('IfcFurniture', 'TABLE', 'G.04', 'table', (12900, 2300), (800, 1200, 750), 'Timber'),
    'Kitchen chair 1': ('IfcFurniture', 'CHAIR', 'G.04', 'chair', (12350, 2700), (450, 450, 850), 'Timber'),
    'Kitchen chair 2': ('IfcFurniture', 'CHAIR', 'G.04', 'chair', (13800, 2700), (450, 450, 850), 'Timber'),
    'Office desk 1': ('IfcFurniture', 'DESK', 'G.07', 'table', (2400, 8900), (1600, 800, 750), 'Timber'),
    'Office desk 2': ('IfcFurniture', 'DESK', 'G.07', 'table', (6200, 8900), (1600, 800, 750), 'Timber'),
    'Office chair 1': ('IfcFurniture', 'CHAIR', 'G.07', 'chair', (3000, 8350), (450, 450, 850), 'Timber'),
    'Office chair 2': ('IfcFurniture', 'CHAIR', 'G.07', 'chair', (6800, 8350), (450, 450, 850), 'Timber'),
    'Meeting table': ('IfcFurniture', 'TABLE', 'G.08', 'table', (3010, 11800), (2400, 1200, 750), 'Timber'),
    'Meeting chair 1': ('IfcFurniture', 'CHAIR', 'G.08', 'chair', (3400, 11200), (450, 450, 850), 'Timber'),
    'Meeting chair 2': ('IfcFurniture', 'CHAIR', 'G.08', 'chair', (4500, 11200), (450, 450, 850), 'Timber'),
    'Store shelf': ('IfcFurniture', 'SHELF', 'G.09', 'box', (6300, 10100), (500, 4600, 2000), 'Steel'),
    'Desk row 1': ('IfcFurniture', 'DESK', 'G.10', 'table', (8400, 12900), (1600, 800, 750), 'Timber'),
    'Desk row 2': ('IfcFurniture', 'DESK', 'G.10', 'table', (10600, 12900), (1600, 800, 750), 'Timber'),
    'Desk row 3': ('IfcFurniture', 'DESK', 'G.10', 'table', (10600, 7800), (1600, 800, 750), 'Timber'),
    'Wardrobe': ('IfcFurniture', 'FILECABINET', 'G.10', 'box', (11700, 10000), (600, 1800, 2000), 'Timber'),
    'Reception desk': ('IfcFurniture', 'DESK', 'G.13', 'box', (21500, 9200), (1800, 700, 1100), 'Timber'),
    'Planter': ('IfcFurniture', 'USERDEFINED', 'G.14', 'box', (20000, 2000), (1000, 1000, 600), 'Concrete'),
    "Director's desk": ('IfcFurniture', 'DESK', 'G.15', 'table', (21200, 12300), (1000, 2000, 750), 'Timber'),
    'Drawing desk 1': ('IfcFurniture', 'DESK', 'U.01', 'table', (800, 600), (1600, 900, 750), 'Timber'),
    'Drawing desk 2': ('IfcFurniture', 'DESK', 'U.01', 'table', (3200, 600), (1600, 900, 750), 'Timber'),
    'Archive shelf 1': ('IfcFurniture', 'SHELF', 'U.02', 'box', (8400, 900), (3400, 500, 2200), 'Steel'),
    'Archive shelf 2': ('IfcFurniture', 'SHELF', 'U.02', 'box', (8400, 2600), (3400, 500, 2200), 'Steel'),
    'Laboratory bench': ('IfcFurniture', 'TABLE', 'U.03', 'table', (13500, 1600), (2400, 1200, 900), 'Timber'),
    'Upper desk 1': ('IfcFurniture', 'DESK', 'U.05', 'table', (600, 12800), (1600, 800, 750), 'Timber'),
    'Upper desk 2': ('IfcFurniture', 'DESK', 'U.06', 'table', (4600, 12800), (1600, 800, 750), 'Timber'),
    'Sofa': ('IfcFurniture', 'SOFA', 'U.07', 'box', (9000, 13700), (2200, 900, 700), 'Textile'),
    'Board table': ('IfcFurniture', 'TABLE', 'U.10', 'table', (18475, 11960), (3600, 1400, 750), 'Timber'),
}
# With the option --cabinet.
CABINET = ('IfcFurniture', 'FILECABINET', 'G.15', 'box', (19600, 10900), (300, 300, 1200), 'Steel')
DUCT = Box(2500, 5700, 2400, 13500, 400, 300)
LIFT_CAR = Box(15080, 12850, 0, 1500, 1600, 2200)
CLEARANCE_DEPTH = 1000

# Red, green, blue, transparency.
MATERIALS = {
    'Concrete': (0.70, 0.70, 0.68, 0.0), 'Brick': (0.62, 0.36, 0.28, 0.0), 'Render': (0.92, 0.90, 0.84, 0.0),
    'Insulation': (0.90, 0.80, 0.50, 0.0), 'Plaster': (0.95, 0.95, 0.93, 0.0), 'Gypsum board': (0.93, 0.93, 0.90, 0.0),
    'Timber': (0.70, 0.52, 0.34, 0.0), 'Steel': (0.55, 0.58, 0.62, 0.0), 'Aluminium': (0.75, 0.77, 0.80, 0.0),
    'Glass': (0.75, 0.88, 0.92, 0.8), 'Ceramic': (0.97, 0.97, 0.97, 0.0), 'Textile': (0.35, 0.40, 0.55, 0.0),
}

TERRAIN_MARGIN = 8000
GRID_BEARING_DEG = 12.0               # from the map's easting to the building's x axis, counter-clockwise

# ------------------------------------------------------------------ the schedule as data


class Task(NamedTuple):
    name: str
    kind: str = None                  # PredefinedType; None takes that of the phase, other text is USERDEFINED
    start: str = None
    finish: str = None
    duration: str = None
    products: tuple = ()              # groups linked by IfcRelAssignsToProduct
    inputs: tuple = ()                # groups linked by IfcRelAssignsToProcess


PHASES = {
    '1': ('Structure', 'CONSTRUCTION'),
    '2': ('Partition walls and rooms', 'CONSTRUCTION'),
    '3': ('Doors, windows, finishes and furniture', 'INSTALLATION'),
}
TASKS = {
    '1.1': Task('Ground slabs', start='2024-03-04T08:00:00', finish='2024-03-08T17:00:00', products=['G slabs', 'G ramp']),
    '1.2': Task('Ground floor exterior walls and columns', start='2024-03-11T08:00:00', duration='P5D',
                products=['G exterior walls', 'G columns', 'G beams']),
    '1.3': Task('Upper slab', start='2024-03-18T08:00:00', finish='2024-03-22T17:00:00', products=['U floor slab']),
    '1.4': Task('Stair', duration='P3D', products=['G stair']),
    '1.5': Task('Upper floor exterior walls and columns', duration='P5D', products=['U exterior walls', 'U columns']),
    '1.6': Task('Roof slab', duration='P4D', products=['U roof slab']),
    '2.1': Task('Partition walls, ground floor', duration='P8D', products=['G partition walls']),
    '2.2': Task('Partition walls, upper floor', duration='P8D', products=['U partition walls'], inputs=['U partition walls']),
    '2.3': Task('Bathroom flooring', start='2024-04-22T08:00:00', duration='P3D', products=['G flooring']),
    '2.4': Task('Building services', 'INSTALLATION', duration='P4D', inputs=['G services']),
    '2.5': Task('Server room fit-out', 'ROOMCLOSED', start='2024-04-29T08:00:00', finish='2024-05-10T17:00:00',
                products=['G.03 room']),
    '3.1': Task('Windows', start='2024-04-29T08:00:00', finish='2024-05-08T17:00:00', products=['G windows', 'U windows']),
    '3.2': Task('Glazed walls', duration='P6D', products=['G curtain walls', 'U curtain walls']),
    '3.3': Task('Doors, ground floor', duration='P5D', products=['G doors']),
    '3.4': Task('Doors, upper floor', duration='P5D', products=['U doors']),
    '3.5': Task('Railings and parapet', start='2024-05-13T08:00:00', duration='P3D',
                products=['U railings', 'U parapet walls']),
    '3.6': Task('Lift car', start='2024-05-27T08:00:00', finish='2024-05-31T17:00:00', products=['G lift']),
    '3.7': Task('Furniture', 'LOGISTIC', duration='P5D', products=['G furniture', 'U furniture']),
    '3.8': Task('Cleaning, upper floor', 'CLEANING', start='2024-06-10T08:00:00', finish='2024-06-14T17:00:00',
                inputs=['U.01 room', 'U.02 room', 'U.03 room']),
    '3.9': Task('Handover', 'ATTENDANCE', duration='P0D'),
}
# Predecessor, successor, type, lag and how the lag is counted.
SEQUENCES = [
    ('1.3', '1.4', 'FINISH_START', 'P1D', 'WORKTIME'),
    ('1.3', '1.5', 'FINISH_START', None, None),
    ('1.5', '1.6', 'FINISH_START', None, None),
    ('1.6', '2.1', 'FINISH_START', None, None),
    ('2.1', '2.2', 'START_START', 'P5D', 'WORKTIME'),
    ('2.1', '2.4', 'FINISH_START', 'P2D', 'ELAPSEDTIME'),
    ('3.1', '3.2', 'FINISH_FINISH', 'P2D', 'WORKTIME'),
    ('3.2', '3.3', 'FINISH_START', None, None),
    ('3.3', '3.4', 'FINISH_START', None, None),
    ('3.4', '3.7', 'FINISH_START', None, None),
    ('3.8', '3.9', 'FINISH_START', None, None),
]
TASK_TYPES = {'CONSTRUCTION', 'INSTALLATION', 'LOGISTIC', 'ATTENDANCE'}
PROJECT_START, SCHEDULE_CREATED = '2024-03-04T08:00:00', '2024-01-15T12:00:00'
WORKING_DAYS, WORKING_HOURS = [1, 2, 3, 4, 5], [('08:00:00', '12:00:00'), ('13:00:00', '17:00:00')]
HOLIDAY = ('Easter Monday', '2024-04-01')

# ------------------------------------------------------------------ plane geometry of the tables


def along_x(rect):
    width, depth = rect.size
    return width >= depth


def gap_rect(wall, centre, width):
    """The plan of an opening in a wall."""
    x0, y0, x1, y1 = WALLS[wall].rect
    lo, hi = centre - width // 2, centre + width // 2
    return Rect(lo, y0, hi, y1) if along_x(WALLS[wall].rect) else Rect(x0, lo, x1, hi)


def borders(corners, rect):
    """Whether a side of the rectangle runs along an edge of the axis-parallel polygon."""
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        if ax == bx:
            touching, overlap = ax in (rect.x0, rect.x1), min(max(ay, by), rect.y1) - max(min(ay, by), rect.y0)
        else:
            touching, overlap = ay in (rect.y0, rect.y1), min(max(ax, bx), rect.x1) - max(min(ax, bx), rect.x0)
        if touching and overlap > 0:
            return True
    return False


def rooms_beside(storey, rect, base, top):
    """Keys of the rooms that a thing with this plan, between these heights above its storey, bounds."""
    floor = STOREYS[storey].floor
    found = []
    for key, room in ROOMS.items():
        room_floor = STOREYS[key[0]].floor
        meets = min(room_floor + room.top, floor + top) > max(room_floor + room.base, floor + base)
        if meets and borders(room.corners, rect):
            found.append(key)
    return found


def centroid(corners):
    """(x, y, area) of a simple polygon."""
    area = x = y = 0
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        cross = ax * by - bx * ay
        area, x, y = area + cross / 2, x + (ax + bx) * cross, y + (ay + by) * cross
    return x / (6 * area), y / (6 * area), area


# ------------------------------------------------------------------ writing IFC entities

GUID_SPACE = uuid.uuid5(uuid.NAMESPACE_URL, 'groundplan/demo')


def global_id(entity, key):
    return ifcopenshell.guid.compress(uuid.uuid5(GUID_SPACE, f'{entity}/{key}').hex)


class Model:
    """The file being written, with the relations that are collected and written at the end."""

    def __init__(self):
        self.file = ifcopenshell.file(schema='IFC4')
        self.shared = {}                         # points and directions by coordinates
        self.keys = set()
        self.groups = defaultdict(list)          # name -> elements and spaces, for the schedule
        self.contained = defaultdict(list)       # spatial structure -> elements
        self.parts = defaultdict(list)           # whole -> parts
        self.typed = defaultdict(list)           # type -> occurrences
        self.made_of = defaultdict(list)         # material -> objects
        self.boundaries = []                     # (room key, element, external)
        self.materials = {}                      # name -> material, layer set usage or constituent set
        self.storeys = {}                        # key -> IfcBuildingStorey
        self.rooms = {}                          # key -> IfcSpace
        self.styles = {}                         # material name -> IfcSurfaceStyle
        self.contexts = {}                       # representation identifier -> sub-context

    def add(self, entity, *args, **attributes):
        return self.file.create_entity(entity, *args, **attributes)

    def root(self, entity, key, **attributes):
        """An entity with a GlobalId, made from its class and a key that is unique in it."""
        assert (entity, key) not in self.keys, f'{entity} {key} occurs twice'
        self.keys.add((entity, key))
        return self.add(entity, GlobalId=global_id(entity, key), **attributes)

    def shared_tuple(self, entity, values):
        values = tuple(float(v) for v in values)
        if (entity, values) not in self.shared:
            self.shared[entity, values] = self.add(entity, values)
        return self.shared[entity, values]

    def point(self, *values):
        return self.shared_tuple('IfcCartesianPoint', values)

    def direction(self, *values):
        return self.shared_tuple('IfcDirection', values)

    def axes(self, origin=(0, 0, 0), z=None, x=None):
        return self.add('IfcAxis2Placement3D', self.point(*origin), z and self.direction(*z), x and self.direction(*x))

    def placed(self, parent, origin=(0, 0, 0), x=None):
        """A local placement that turns about z only: `x` is the direction of its x axis in the parent."""
        return self.add('IfcLocalPlacement', parent, self.axes(origin, (0, 0, 1) if x else None, x and (*x, 0)))

    # Solids.

    def extrude(self, profile, height, axes):
        return self.add('IfcExtrudedAreaSolid', profile, axes, self.direction(0, 0, 1), float(height))

    def outline(self, corners):
        points = [self.point(*c) for c in [*corners, corners[0]]]
        return self.add('IfcArbitraryClosedProfileDef', 'AREA', None, self.add('IfcPolyline', points))

    def box(self, box):
        middle = self.add('IfcAxis2Placement2D', self.point(box.dx / 2, box.dy / 2))
        profile = self.add('IfcRectangleProfileDef', 'AREA', None, middle, float(box.dx), float(box.dy))
        solid = self.extrude(profile, box.dz, self.axes((box.x, box.y, box.z)))
        if box.glass:
            self.add('IfcStyledItem', solid, [self.styles['Glass']])
        return solid

    def prism(self, corners, base, height):
        return self.extrude(self.outline(corners), height, self.axes((0, 0, base)))

    def side_prism(self, corners, x, width):
        """A prism lying on its side: corners are (y, z), it reaches from x to x + width."""
        return self.extrude(self.outline(corners), width, self.axes((x, 0, 0), (1, 0, 0), (0, 1, 0)))

    # Representations.

    def representation(self, name, kind, items):
        return self.add('IfcShapeRepresentation', self.contexts[name], name, kind, items)

    def body(self, solids):
        return self.representation('Body', 'SweptSolid', solids)

    def shape(self, *representations):
        return self.add('IfcProductDefinitionShape', None, None, representations)

    # Elements and their relations.

    def element(self, entity, key, storey, solids, origin=(0, 0, 0), room=None, group=None, material=None, **attributes):
        """An element with a body, in a storey or in one of its rooms; solids are relative to the origin."""
        made = self.root(entity, key, Name=key, ObjectPlacement=self.placed(self.storeys[storey].ObjectPlacement, origin),
                         Representation=self.shape(self.body(solids)), **attributes)
        self.contained[self.rooms[room] if room else self.storeys[storey]].append(made)
        self.note(made, group, material)
        return made

    def note(self, made, group=None, material=None):
        if group:
            self.groups[group].append(made)
        if material:
            self.made_of[self.materials[material]].append(made)

    def property_set(self, key, name, **values):
        """Values are pairs (IFC type, value)."""
        properties = [self.add('IfcPropertySingleValue', n, None, self.add(*v)) for n, v in values.items()]
        return self.root('IfcPropertySet', key, Name=name, HasProperties=properties)

    def define(self, objects, key, name, **values):
        """One property set shared by several objects."""
        properties = self.property_set(key, name, **values)
        self.root('IfcRelDefinesByProperties', key, RelatedObjects=objects, RelatingPropertyDefinition=properties)

    def write_relations(self):
        for structure, elements in self.contained.items():
            self.root('IfcRelContainedInSpatialStructure', structure.GlobalId, RelatedElements=elements,
                      RelatingStructure=structure)
        for whole, parts in self.parts.items():
            self.root('IfcRelAggregates', whole.GlobalId, RelatingObject=whole, RelatedObjects=parts)
        for kind, occurrences in self.typed.items():
            self.root('IfcRelDefinesByType', kind.GlobalId, RelatedObjects=occurrences, RelatingType=kind)
        for material, objects in self.made_of.items():
            self.root('IfcRelAssociatesMaterial', objects[0].GlobalId, RelatedObjects=objects, RelatingMaterial=material)
        for room, element, external in self.boundaries:
            virtual = element.is_a('IfcVirtualElement')
            self.root('IfcRelSpaceBoundary1stLevel', f'{room}/{element.GlobalId}', Name='1stLevel',
                      RelatingSpace=self.rooms[room], RelatedBuildingElement=element,
                      PhysicalOrVirtualBoundary='VIRTUAL' if virtual else 'PHYSICAL',
                      InternalOrExternalBoundary='EXTERNAL' if external else 'INTERNAL')


# ------------------------------------------------------------------ project, site, storeys, materials


def write_project(m):
    units = write_units(m)
    turn = math.radians(GRID_BEARING_DEG)
    sine, cosine = round(math.sin(turn), 9), round(math.cos(turn), 9)
    context = m.add('IfcGeometricRepresentationContext', ContextType='Model', CoordinateSpaceDimension=3, Precision=0.01,
                    WorldCoordinateSystem=m.axes(), TrueNorth=m.direction(sine, cosine))
    views = {'Body': 'MODEL_VIEW', 'Axis': 'GRAPH_VIEW', 'FootPrint': 'PLAN_VIEW', 'Clearance': 'MODEL_VIEW'}
    m.contexts = {name: m.add('IfcGeometricRepresentationSubContext', ContextIdentifier=name, ContextType='Model',
                              ParentContext=context, TargetView=view) for name, view in views.items()}
    metre = m.add('IfcSIUnit', UnitType='LENGTHUNIT', Name='METRE')
    grid = m.add('IfcProjectedCRS', Name='EPSG:25832', Description='ETRS89 / UTM zone 32N', GeodeticDatum='ETRS89',
                 MapProjection='UTM', MapZone='32N', MapUnit=metre)
    m.add('IfcMapConversion', SourceCRS=context, TargetCRS=grid, Eastings=500120.0, Northings=5700340.0,
          OrthogonalHeight=61.5, XAxisAbscissa=cosine, XAxisOrdinate=sine, Scale=0.001)
    return m.root('IfcProject', 'demo', Name='groundplan demo', LongName='Demo building', RepresentationContexts=[context],
                  UnitsInContext=units)


def write_units(m):
    radian = m.add('IfcSIUnit', UnitType='PLANEANGLEUNIT', Name='RADIAN')
    per_degree = m.add('IfcMeasureWithUnit', m.add('IfcPlaneAngleMeasure', math.radians(1)), radian)
    degree = m.add('IfcConversionBasedUnit', m.add('IfcDimensionalExponents', 0, 0, 0, 0, 0, 0, 0), 'PLANEANGLEUNIT',
                   'DEGREE', per_degree)
    return m.add('IfcUnitAssignment', [
        m.add('IfcSIUnit', UnitType='LENGTHUNIT', Prefix='MILLI', Name='METRE'),
        m.add('IfcSIUnit', UnitType='AREAUNIT', Name='SQUARE_METRE'),
        m.add('IfcSIUnit', UnitType='VOLUMEUNIT', Name='CUBIC_METRE'),
        m.add('IfcSIUnit', UnitType='TIMEUNIT', Name='SECOND'),
        degree,
    ])


def write_spatial_structure(m, project):
    site = m.root('IfcSite', 'site', Name='Site', ObjectPlacement=m.placed(None), Representation=m.shape(terrain(m)),
                  CompositionType='ELEMENT', RefElevation=61500.0)
    building = m.root('IfcBuilding', 'building', Name='Office', ObjectPlacement=m.placed(site.ObjectPlacement),
                      CompositionType='ELEMENT')
    m.parts[project] = [site]
    m.parts[site] = [building]
    for key, (name, floor) in STOREYS.items():
        m.storeys[key] = m.root('IfcBuildingStorey', key, Name=name, CompositionType='ELEMENT', Elevation=float(floor),
                                ObjectPlacement=m.placed(building.ObjectPlacement, (0, 0, floor)))
        m.parts[building].append(m.storeys[key])


def terrain(m):
    """A ring of ground around the building, falling gently to the south-west, everywhere below the floor."""
    x0, y0, x1, y1 = OUTLINE
    outer = Rect(x0 - TERRAIN_MARGIN, y0 - TERRAIN_MARGIN, x1 + TERRAIN_MARGIN, y1 + TERRAIN_MARGIN)
    points = [(float(x), float(y), -270 + 0.004 * x + 0.002 * y) for x, y in outer.corners + OUTLINE.corners]
    faces = []
    for i in range(4):
        j = (i + 1) % 4
        faces += [(i + 1, j + 1, j + 5), (i + 1, j + 5, i + 5)]
    surface = m.add('IfcTriangulatedFaceSet', Coordinates=m.add('IfcCartesianPointList3D', points), Closed=False,
                    CoordIndex=faces)
    return m.representation('Body', 'Tessellation', [surface])


def write_materials(m):
    for name, (red, green, blue, transparency) in MATERIALS.items():
        m.materials[name] = m.add('IfcMaterial', Name=name, Category=name.lower())
        colour = m.add('IfcSurfaceStyleShading', m.add('IfcColourRgb', None, red, green, blue), transparency)
        m.styles[name] = m.add('IfcSurfaceStyle', name, 'BOTH', [colour])
        styled = m.add('IfcStyledRepresentation', m.contexts['Body'], 'Style', 'Material',
                       [m.add('IfcStyledItem', None, [m.styles[name]])])
        m.add('IfcMaterialDefinitionRepresentation', None, None, [styled], m.materials[name])
    parts = [m.add('IfcMaterialConstituent', part, None, m.materials[material])
             for part, material in (('Lining', 'Aluminium'), ('Glazing', 'Glass'))]
    m.materials['Glazed frame'] = m.add('IfcMaterialConstituentSet', 'Glazed frame', None, parts)
    layers = [m.add('IfcMaterialLayer', m.materials[name], float(thickness)) for name, thickness in WALL_LAYERS]
    layer_set = m.add('IfcMaterialLayerSet', layers, 'Exterior wall')
    m.materials['Exterior wall'] = m.add('IfcMaterialLayerSetUsage', layer_set, 'AXIS2', 'NEGATIVE',
                                         sum(thickness for _, thickness in WALL_LAYERS) / 2)


# ------------------------------------------------------------------ rooms, slabs, walls


def write_rooms(m):
    for key, room in ROOMS.items():
        storey = m.storeys[key[0]]
        space = m.root('IfcSpace', key, Name=key, LongName=room.long_name, CompositionType='ELEMENT',
                       PredefinedType='INTERNAL', ObjectPlacement=m.placed(storey.ObjectPlacement),
                       Representation=m.shape(m.body([m.prism(room.corners, room.base, room.top - room.base)])))
        m.rooms[key] = space
        m.parts[storey].append(space)
        m.groups[f'{key} room'] = [space]
        if room.ready:
            m.define([space], f'Room Schedule/{key}', 'Room Schedule', RoomDate=('IfcText', room.ready))


def write_slabs(m):
    groups = {'BASESLAB': 'slabs', 'LANDING': 'slabs', 'FLOOR': 'floor slab', 'ROOF': 'roof slab'}
    slabs = {}
    for key, (corners, top, thickness, kind) in SLABS.items():
        slabs[key] = m.element('IfcSlab', key, key[0], [m.prism(corners, top - thickness, thickness)], PredefinedType=kind,
                               group=f'{key[0]} {groups[kind]}', material='Concrete')
    upper = slabs['U.slab']
    for key, hole in SLAB_HOLES.items():
        cut = m.prism(hole.corners, -UPPER_SLAB - 50, UPPER_SLAB + 100)
        write_opening(m, key, upper, m.placed(upper.ObjectPlacement), cut)
    flooring = m.prism(BATHROOM.corners, 0, BATHROOM_FLOORING)
    m.element('IfcCovering', 'G.bathroom flooring', 'G', [flooring], room='G.05', PredefinedType='FLOORING',
              group='G flooring', material='Ceramic')


def write_opening(m, key, host, placement, solid):
    opening = m.root('IfcOpeningElement', key, Name=key, ObjectPlacement=placement, PredefinedType='OPENING',
                     Representation=m.shape(m.body([solid])))
    m.root('IfcRelVoidsElement', key, RelatingBuildingElement=host, RelatedOpeningElement=opening)
    return opening


def write_walls(m):
    """Walls lie on their axis: x along it from the lower end, y to its left."""
    exterior = m.root('IfcWallType', 'exterior', Name='Exterior wall 300', PredefinedType='STANDARD', HasPropertySets=[
        m.property_set('Pset_WallCommon/exterior', 'Pset_WallCommon', LoadBearing=('IfcBoolean', True),
                       FireRating=('IfcLabel', 'REI 90'), ThermalTransmittance=('IfcThermalTransmittanceMeasure', 0.21))])
    walls = {key: write_wall(m, key, wall) for key, wall in WALLS.items()}
    for group, date in WALL_DATES.items():
        m.define(m.groups[group], f'Wall Schedule/{group}', 'Wall Schedule', ConstructionDate=('IfcText', date))
    for is_external in (True, False):
        chosen = [walls[key] for key, wall in WALLS.items() if (wall.kind == 'exterior') == is_external]
        m.define(chosen, f'Pset_WallCommon/external {is_external}', 'Pset_WallCommon', IsExternal=('IfcBoolean', is_external))
        if is_external:
            m.typed[exterior] = chosen
    return walls


def write_wall(m, key, wall):
    (x0, y0, x1, y1), (width, depth) = wall.rect, wall.rect.size
    length, thickness = max(width, depth), min(width, depth)
    origin, x = ((x0, (y0 + y1) / 2), (1, 0)) if along_x(wall.rect) else (((x0 + x1) / 2, y0), (0, 1))
    axis = m.add('IfcPolyline', [m.point(0, 0), m.point(length, 0)])
    solid = m.box(Box(0, -thickness / 2, 0, length, thickness, wall.top - wall.base))
    made = m.root('IfcWall', key, Name=key, PredefinedType='PARAPET' if wall.kind == 'parapet' else 'STANDARD',
                  ObjectPlacement=m.placed(m.storeys[key[0]].ObjectPlacement, (*origin, wall.base), x),
                  Representation=m.shape(m.representation('Axis', 'Curve2D', [axis]), m.body([solid])))
    m.contained[m.storeys[key[0]]].append(made)
    m.note(made, f'{key[0]} {wall.kind} walls', WALL_MATERIALS.get(wall.kind, 'Exterior wall'))
    for room in rooms_beside(key[0], wall.rect, wall.base, wall.top):
        m.boundaries.append((room, made, wall.kind == 'exterior'))
    return made


# ------------------------------------------------------------------ what stands in walls


def wall_opening(m, key, walls, wall, centre, width, height, sill):
    """An opening as deep as its wall; its origin is at the lower end, on the wall's axis."""
    rect, base = WALLS[wall].rect, WALLS[wall].base
    start, thickness = (rect.x0 if along_x(rect) else rect.y0), min(rect.size)
    placement = m.placed(walls[wall].ObjectPlacement, (centre - width / 2 - start, 0, sill - base))
    solid = m.box(Box(0, -thickness / 2, 0, width, thickness, height))
    return write_opening(m, key, walls[wall], placement, solid)


def write_cased_openings(m, walls):
    for key, (wall, centre, width, height) in CASED_OPENINGS.items():
        wall_opening(m, key, walls, wall, centre, width, height, 0)


def fill(m, opening, element, wall, rect, base, top):
    """Hang a door or window in an opening and say which rooms it bounds."""
    storey = wall[0]
    m.root('IfcRelFillsElement', element.Name, RelatingOpeningElement=opening, RelatedBuildingElement=element)
    m.contained[m.storeys[storey]].append(element)
    for room in rooms_beside(storey, rect, base, top):
        m.boundaries.append((room, element, WALLS[wall].kind == 'exterior'))


def mapped(m, shape_map, width, mirrored):
    """The body of an occurrence: its type's shape, or the mirror image that fills the same opening."""
    axes = (m.direction(-1, 0, 0), m.direction(0, 1, 0)) if mirrored else (None, None)
    operator = m.add('IfcCartesianTransformationOperator3D', *axes, m.point(width if mirrored else 0, 0, 0), None,
                     m.direction(0, 0, 1) if mirrored else None)
    return m.representation('Body', 'MappedRepresentation', [m.add('IfcMappedItem', shape_map, operator)])


def shape_map(m, boxes):
    return m.add('IfcRepresentationMap', m.axes(), m.body([m.box(b) for b in boxes]))


def frame_boxes(width, height, bottom):
    """Jambs and head, and a sill piece if wanted, around a clear opening; the wall's axis is y = 0."""
    y, depth = -LINING_DEPTH / 2, LINING_DEPTH
    inner = width - 2 * LINING
    boxes = [Box(0, y, 0, LINING, depth, height), Box(width - LINING, y, 0, LINING, depth, height),
             Box(LINING, y, height - LINING, inner, depth, LINING)]
    return boxes + ([Box(LINING, y, 0, inner, depth, LINING)] if bottom else [])


def door_boxes(width, height, panels, glass):
    leaf = (width - 2 * LINING) / panels
    leaves = [Box(LINING + i * leaf, -LEAF / 2, 0, leaf, LEAF, height - LINING, glass) for i in range(panels)]
    return frame_boxes(width, height, bottom=False) + leaves


def door_type(m, key, door, glass):
    operation, positions = PANELS[door.operation]
    lining = m.root('IfcDoorLiningProperties', key, Name='Lining', LiningDepth=float(LINING_DEPTH),
                    LiningThickness=float(LINING))
    panels = [m.root('IfcDoorPanelProperties', f'{key}/{position}', Name='Panel', PanelDepth=float(LEAF),
                     PanelOperation=operation, PanelWidth=1 / len(positions), PanelPosition=position)
              for position in positions]
    common = m.property_set(f'Pset_DoorCommon/{key}', 'Pset_DoorCommon', FireRating=('IfcLabel', 'EI 30'))
    made = m.root('IfcDoorType', key, Name=key, PredefinedType='DOOR', OperationType=door.operation,
                  HasPropertySets=[lining, *panels, common],
                  RepresentationMaps=[shape_map(m, door_boxes(door.width, door.height, len(positions), glass))])
    m.note(made, material='Glazed frame' if glass else 'Timber')
    return made


def write_doors(m, walls):
    """The leaf swings to the door's +y. A door that faces the wall's right is turned about, from the opening's far end."""
    types, hung = {}, defaultdict(list)
    for key, door in DOORS.items():
        glass = key in GLAZED_DOORS
        kind = f"{door.operation} {door.width} x {door.height}{' glazed' if glass else ''}"
        if kind not in types:
            types[kind] = door_type(m, kind, door, glass)
        opening = wall_opening(m, f'{key}, opening', walls, door.wall, door.centre, door.width, door.height, door.sill)
        turned = door.faces in 'SE'
        from_far_end = dict(origin=(door.width, 0, 0), x=(-1, 0)) if turned else {}
        placement = m.placed(opening.ObjectPlacement, **from_far_end)
        shapes = [mapped(m, types[kind].RepresentationMaps[0], door.width, door.mirrored), *extra_shapes(m, key, door)]
        made = m.root('IfcDoor', key, Name=key, ObjectPlacement=placement, Representation=m.shape(*shapes),
                      OverallHeight=float(door.height), OverallWidth=float(door.width), PredefinedType='DOOR')
        m.typed[types[kind]].append(made)
        fill(m, opening, made, door.wall, gap_rect(door.wall, door.centre, door.width), door.sill, door.sill + door.height)
        m.note(made, None if key in DOORS_WITHOUT_TASK else f'{key[0]} doors')
        hung[door.hung].append(made)
    for date, doors in hung.items():
        m.define(doors, f'Door Schedule/{date}', 'Door Schedule', DoorDate=('IfcText', date))


def extra_shapes(m, key, door):
    """Representations that say something about a door but are none of its body."""
    if key == DOOR_WITH_CLEARANCE:
        space = Box(0, -LINING_DEPTH / 2 - CLEARANCE_DEPTH, 0, door.width, CLEARANCE_DEPTH, door.height)
        return [m.representation('Clearance', 'SweptSolid', [m.box(space)])]
    if key == DOOR_WITH_FOOTPRINT:
        hinge = m.point(LINING, 0)
        circle = m.add('IfcCircle', m.add('IfcAxis2Placement2D', hinge), float(door.width - 2 * LINING))
        trims = [[m.add('IfcParameterValue', angle)] for angle in (0.0, 90.0)]
        arc = m.add('IfcTrimmedCurve', circle, *trims, True, 'PARAMETER')
        leaf = m.add('IfcPolyline', [hinge, m.point(LINING, door.width - 2 * LINING)])
        return [m.representation('FootPrint', 'GeometricCurveSet', [m.add('IfcGeometricCurveSet', [arc, leaf])])]
    return []


def window_type(m, width):
    pane = Box(LINING, -PANE / 2, LINING, width - 2 * LINING, PANE, WINDOW_HEIGHT - 2 * LINING, glass=True)
    made = m.root('IfcWindowType', str(width), Name=f'Window {width} x {WINDOW_HEIGHT}', PredefinedType='WINDOW',
                  PartitioningType='SINGLE_PANEL',
                  RepresentationMaps=[shape_map(m, [*frame_boxes(width, WINDOW_HEIGHT, bottom=True), pane])])
    m.note(made, material='Glazed frame')
    return made


def write_windows(m, walls):
    types = {width: window_type(m, width) for width in dict.fromkeys(width for _, width, _ in WINDOWS)}
    for wall, width, centres in WINDOWS:
        for n, centre in enumerate(centres, 1):
            key = f'{wall} window {width}/{n}'
            opening = wall_opening(m, f'{key}, opening', walls, wall, centre, width, WINDOW_HEIGHT, SILL)
            made = m.root('IfcWindow', key, Name=key, ObjectPlacement=m.placed(opening.ObjectPlacement),
                          Representation=m.shape(mapped(m, types[width].RepresentationMaps[0], width, mirrored=False)),
                          OverallHeight=float(WINDOW_HEIGHT), OverallWidth=float(width), PredefinedType='WINDOW')
            m.typed[types[width]].append(made)
            fill(m, opening, made, wall, gap_rect(wall, centre, width), SILL, SILL + WINDOW_HEIGHT)
            m.note(made, f'{wall[0]} windows')


# ------------------------------------------------------------------ other elements


def write_columns_and_beams(m):
    for key, ((x, y), size, height, is_round) in COLUMNS.items():
        middle = m.add('IfcAxis2Placement2D', m.point(0, 0))
        if is_round:
            profile = m.add('IfcCircleProfileDef', 'AREA', None, middle, size / 2)
        else:
            profile = m.add('IfcRectangleProfileDef', 'AREA', None, middle, float(size), float(size))
        m.element('IfcColumn', key, key[0], [m.extrude(profile, height, m.axes())], (x, y, 0), PredefinedType='COLUMN',
                  group=f'{key[0]} columns', material='Concrete')
    for key, (rect, bottom, top) in BEAMS.items():
        m.element('IfcBeam', key, key[0], [m.box(Box(0, 0, 0, *rect.size, top - bottom))], (rect.x0, rect.y0, bottom),
                  PredefinedType='BEAM', group=f'{key[0]} beams', material='Concrete')


def write_stair(m):
    width, run = STAIR.size
    riser = STOREYS['U'].floor / RISERS
    steps = [(0, 0)]
    for i in range(RISERS - 1):
        steps += [(i * TREAD, (i + 1) * riser), ((i + 1) * TREAD, (i + 1) * riser)]
    top = (RISERS - 1) * riser
    soffit = [(run, top - WAIST), (WAIST * TREAD / riser, 0)]
    rise = RISERS * riser                        # the line of the nosings ends on the upper floor
    guard = [(0, riser + 100), (run, rise + 100), (run, rise + 1000), (0, riser + 1000)]
    stair = write_whole(m, 'IfcStair', 'G.stair', 'G', (STAIR.x0, STAIR.y0, 0), 'STRAIGHT_RUN_STAIR', 'G stair')
    write_part(m, stair, 'IfcStairFlight', 'G.stair flight', [m.side_prism(steps + soffit, 0, width)], 'Concrete', 'STRAIGHT',
               NumberOfRisers=RISERS, NumberOfTreads=RISERS - 1, RiserHeight=riser, TreadLength=float(TREAD))
    write_part(m, stair, 'IfcRailing', 'G.stair railing', [m.side_prism(guard, width - 40, 40)], 'Steel', 'HANDRAIL')


def write_ramp(m):
    width, run = RAMP.size
    ramp = write_whole(m, 'IfcRamp', 'G.dock ramp', 'G', (RAMP.x0, RAMP.y0, 0), 'STRAIGHT_RUN_RAMP', 'G ramp')
    wedge = [(0, DOCK_LEVEL), (run, DOCK_LEVEL), (run, 0)]
    write_part(m, ramp, 'IfcRampFlight', 'G.dock ramp flight', [m.side_prism(wedge, 0, width)], 'Concrete', 'STRAIGHT')


def write_whole(m, entity, key, storey, origin, kind, group):
    """An element without a shape of its own, made of parts."""
    whole = m.root(entity, key, Name=key, PredefinedType=kind,
                   ObjectPlacement=m.placed(m.storeys[storey].ObjectPlacement, origin))
    m.contained[m.storeys[storey]].append(whole)
    m.note(whole, group)
    return whole


def write_part(m, whole, entity, key, solids, material, kind, **attributes):
    part = m.root(entity, key, Name=key, PredefinedType=kind, ObjectPlacement=m.placed(whole.ObjectPlacement),
                  Representation=m.shape(m.body(solids)), **attributes)
    m.parts[whole].append(part)
    m.note(part, material=material)


def write_railings(m):
    for key, rect in RAILINGS.items():
        m.element('IfcRailing', key, key[0], [m.box(b) for b in railing_boxes(rect)], (rect.x0, rect.y0, 0),
                  PredefinedType='GUARDRAIL', group=f'{key[0]} railings', material='Steel')


def railing_boxes(rect):
    """Posts at most 1.5 m apart, glass between them, a rail on top."""
    length, thickness = max(rect.size), min(rect.size)
    rail = 40
    bays = math.ceil(length / 1500)
    pitch = (length - thickness) / bays
    boxes = [Box(i * pitch, 0, 0, thickness, thickness, RAILING_HEIGHT - rail) for i in range(bays + 1)]
    boxes += [Box(i * pitch + thickness, thickness / 2 - 6, 80, pitch - thickness, 12, RAILING_HEIGHT - 200, glass=True)
              for i in range(bays)]
    boxes.append(Box(0, 0, RAILING_HEIGHT - rail, length, thickness, rail))
    if along_x(rect):
        return boxes
    return [Box(b.y, b.x, b.z, b.dy, b.dx, b.dz, b.glass) for b in boxes]


def write_curtain_walls(m):
    """Transoms below and above, mullions between them, a pane in each bay."""
    for key, rect in CURTAIN_WALLS.items():
        depth, length = rect.size
        whole = write_whole(m, 'IfcCurtainWall', key, key[0], (rect.x0, rect.y0, 0), 'NOTDEFINED', f'{key[0]} curtain walls')
        for name, z in (('sill', 0), ('head', CLEAR_HEIGHT - TRANSOM)):
            transom = Box(0, 0, z, depth, length, TRANSOM)
            write_part(m, whole, 'IfcMember', f'{key} {name}', [m.box(transom)], 'Aluminium', 'MULLION')
        height = CLEAR_HEIGHT - 2 * TRANSOM
        pitch = (length - MULLION) / CURTAIN_BAYS
        for i in range(CURTAIN_BAYS + 1):
            mullion = Box(0, i * pitch, TRANSOM, depth, MULLION, height)
            write_part(m, whole, 'IfcMember', f'{key} mullion {i + 1}', [m.box(mullion)], 'Aluminium', 'MULLION')
        for i in range(CURTAIN_BAYS):
            pane = Box((depth - PANE) / 2, i * pitch + MULLION, TRANSOM, PANE, pitch - MULLION, height, glass=True)
            write_part(m, whole, 'IfcPlate', f'{key} pane {i + 1}', [m.box(pane)], 'Glass', 'CURTAIN_PANEL')
        for room in rooms_beside(key[0], rect, 0, CLEAR_HEIGHT):
            m.boundaries.append((room, whole, True))


def write_furnishings(m):
    shapes = {'box': lambda w, d, h: [Box(0, 0, 0, w, d, h)], 'table': table_boxes, 'chair': chair_boxes}
    for key, (entity, kind, room, shape, (x, y), size, material) in FURNISHINGS.items():
        group = {'IfcFurniture': 'furniture', 'IfcBoiler': 'services'}.get(entity)
        attributes = dict(ObjectType=key) if kind == 'USERDEFINED' else {}
        m.element(entity, key, room[0], [m.box(b) for b in shapes[shape](*size)], (x, y, ROOMS[room].base), room=room,
                  PredefinedType=kind, group=group and f'{room[0]} {group}', material=material, **attributes)


def table_boxes(width, depth, height):
    leg, top = 60, 30
    legs = [Box(x, y, 0, leg, leg, height - top) for x in (0, width - leg) for y in (0, depth - leg)]
    return [*legs, Box(0, 0, height - top, width, depth, top)]


def chair_boxes(width, depth, height):
    seat = 450
    return [Box(0, 0, 0, width, depth, seat), Box(0, depth - 50, seat, width, 50, height - seat)]


def write_services_and_lift(m):
    for entity, key, box, kind, group in (
            ('IfcDuctSegment', 'G.duct', DUCT, 'RIGIDSEGMENT', 'G services'),
            ('IfcTransportElement', 'G.lift car', LIFT_CAR, 'ELEVATOR', 'G lift')):
        m.element(entity, key, 'G', [m.box(box._replace(x=0, y=0, z=0))], (box.x, box.y, box.z), PredefinedType=kind,
                  group=group, material='Steel')


def write_virtual_boundary(m):
    """Foyer and atrium are one hall; what parts them is no obstacle though it has a body."""
    x, y = ATRIUM.x0, ATRIUM.y1
    screens = [Box(x - 10, ATRIUM.y0, 0, 10, y - ATRIUM.y0, CLEAR_HEIGHT), Box(x, y, 0, 23700 - x, 10, CLEAR_HEIGHT)]
    made = m.element('IfcVirtualElement', 'G.foyer to atrium', 'G', [m.box(b) for b in screens])
    m.boundaries += [(room, made, False) for room in ('G.13', 'G.14')]


# ------------------------------------------------------------------ schedule


def write_schedule(m, project):
    common = dict(CreationDate=SCHEDULE_CREATED, StartTime=PROJECT_START, PredefinedType='PLANNED')
    plan = m.root('IfcWorkPlan', 'plan', Name='Construction', **common)
    schedule = m.root('IfcWorkSchedule', 'schedule', Name='Construction schedule', **common)
    m.parts[plan] = [schedule]
    calendar = write_calendar(m)
    phases = {number: m.root('IfcTask', number, Name=name, Identification=number, IsMilestone=False, PredefinedType=kind)
              for number, (name, kind) in PHASES.items()}
    tasks = {number: write_task(m, number, task) for number, task in TASKS.items()}
    for number, phase in phases.items():
        nested = [task for key, task in tasks.items() if key.startswith(number)]
        m.root('IfcRelNests', number, RelatingObject=phase, RelatedObjects=nested)
    for name, control in (('schedule', schedule), ('calendar', calendar)):
        m.root('IfcRelAssignsToControl', name, RelatedObjects=list(phases.values()), RelatingControl=control)
    m.root('IfcRelDeclares', 'schedule', RelatingContext=project, RelatedDefinitions=[plan, calendar])
    for before, after, kind, lag, counted in SEQUENCES:
        lag_time = lag and m.add('IfcLagTime', LagValue=m.add('IfcDuration', lag), DurationType=counted)
        m.root('IfcRelSequence', f'{before}/{after}', RelatingProcess=tasks[before], RelatedProcess=tasks[after],
               TimeLag=lag_time, SequenceType=kind)
    link_products(m, tasks)
    number_products(m)


def write_calendar(m):
    periods = [m.add('IfcTimePeriod', *hours) for hours in WORKING_HOURS]
    weekly = m.add('IfcRecurrencePattern', RecurrenceType='WEEKLY', WeekdayComponent=WORKING_DAYS, TimePeriods=periods)
    holiday, day = HOLIDAY
    return m.root('IfcWorkCalendar', 'calendar', Name='Working days', PredefinedType='FIRSTSHIFT',
                  WorkingTimes=[m.add('IfcWorkTime', Name='Monday to Friday', RecurrencePattern=weekly)],
                  ExceptionTimes=[m.add('IfcWorkTime', Name=holiday, Start=day, Finish=day)])


def write_task(m, number, task):
    time = m.add('IfcTaskTime', DurationType='WORKTIME', ScheduleDuration=task.duration, ScheduleStart=task.start,
                 ScheduleFinish=task.finish)
    own_type = task.kind and task.kind not in TASK_TYPES
    return m.root('IfcTask', number, Name=task.name, Identification=number, IsMilestone=task.duration == 'P0D', TaskTime=time,
                  ObjectType=task.kind if own_type else None, PredefinedType='USERDEFINED' if own_type else task.kind)


def link_products(m, tasks):
    for number, task in TASKS.items():
        for product in [p for group in task.products for p in m.groups[group]]:
            m.root('IfcRelAssignsToProduct', f'{number}/{product.GlobalId}', RelatedObjects=[tasks[number]],
                   RelatingProduct=product)
        inputs = [p for group in task.inputs for p in m.groups[group]]
        if inputs:
            m.root('IfcRelAssignsToProcess', number, RelatedObjects=inputs, RelatingProcess=tasks[number])


def number_products(m):
    """The number of its activity on every element and room with a task, by which schedule files are linked."""
    for number, task in TASKS.items():
        products = [p for group in dict.fromkeys([*task.products, *task.inputs]) for p in m.groups[group]]
        if products:
            m.define(products, f'Construction/{number}', 'Construction', **{'4D_Number': ('IfcLabel', number)})


# ------------------------------------------------------------------ the whole, and what tests want to know


def build():
    """The whole model."""
    m = Model()
    project = write_project(m)
    write_materials(m)
    write_spatial_structure(m, project)
    write_rooms(m)
    write_slabs(m)
    walls = write_walls(m)
    write_cased_openings(m, walls)
    write_doors(m, walls)
    write_windows(m, walls)
    write_columns_and_beams(m)
    write_stair(m)
    write_ramp(m)
    write_railings(m)
    write_curtain_walls(m)
    write_furnishings(m)
    write_services_and_lift(m)
    write_virtual_boundary(m)
    write_schedule(m, project)
    m.write_relations()
    name_file(m.file)
    return m.file


def name_file(file):
    description, name = file.header.file_description, file.header.file_name
    description.description = ('ViewDefinition [DesignTransferView_V1.0]',)
    name.name, name.time_stamp = 'demo.ifc', SCHEDULE_CREATED
    name.author = name.organization = ('groundplan',)
    name.preprocessor_version = name.originating_system = 'groundplan demo model'
    name.authorization = ''


def metres(value):
    """A length or nested list of lengths in metres, to a tenth of a millimetre."""
    if isinstance(value, (list, tuple)):
        return [metres(v) for v in value]
    return round(value / 1000, 4)


def facts():
    """Figures that tests need, from the tables alone."""
    return dict(
        storeys={key: dict(name=name, global_id=global_id('IfcBuildingStorey', key), floor_z_m=metres(floor))
                 for key, (name, floor) in STOREYS.items()},
        spaces={key: space_facts(key, room) for key, room in ROOMS.items()},
        doors={key: door_facts(key, door) for key, door in DOORS.items()},
        cased_openings={key: dict(storey=key[0], rectangle_m=metres(gap_rect(wall, centre, width)), width_m=metres(width))
                        for key, (wall, centre, width, _) in CASED_OPENINGS.items()},
        columns={key: dict(centre_m=metres(centre), size_m=metres(size), round=is_round)
                 for key, (centre, size, _, is_round) in COLUMNS.items()},
        rectangles_m={name: metres(rect) for name, rect in dict(
            outline=OUTLINE, stair=STAIR, stair_hole=STAIR_HOLE, atrium_hole=ATRIUM, shaft=SHAFT,
            bathroom=BATHROOM, dock=DOCK, ramp=RAMP).items()},
        levels_m=dict(bathroom=metres(BATHROOM_FLOORING), dock=metres(DOCK_LEVEL)),
        stair=dict(risers=RISERS, treads=RISERS - 1, riser_height_m=metres(STOREYS['U'].floor / RISERS),
                   tread_length_m=metres(TREAD)),
    )


def space_facts(key, room):
    x, y, area = centroid(room.corners)
    floor = STOREYS[key[0]].floor + room.base
    return dict(long_name=room.long_name, global_id=global_id('IfcSpace', key), storey=key[0], floor_z_m=metres(floor),
                height_m=metres(room.top - room.base), corners_m=metres(room.corners), centroid_m=metres([x, y]),
                area_m2=round(area / 1e6, 4))


def door_facts(key, door):
    rect = gap_rect(door.wall, door.centre, door.width)
    operation = door.operation
    if door.mirrored:
        operation = operation.replace('LEFT', 'RIGHT') if 'LEFT' in operation else operation.replace('RIGHT', 'LEFT')
    return dict(global_id=global_id('IfcDoor', key), storey=key[0], operation_type=operation, faces=door.faces,
                width_m=metres(door.width), height_m=metres(door.height),
                clear_width_m=metres(door.width - 2 * LINING - LEAF),
                centre_m=metres([(rect.x0 + rect.x1) / 2, (rect.y0 + rect.y1) / 2, STOREYS[key[0]].floor + door.sill]),
                opening_m=metres(rect), spaces=rooms_beside(key[0], rect, door.sill, door.sill + door.height))


def main():
    parser = argparse.ArgumentParser(description='Writes the demo building, an office of two storeys in IFC4.')
    parser.add_argument('output', nargs='?', metavar='FILE.ifc', help='where to write the model')
    parser.add_argument('--cabinet', action='store_true', help='a cabinet stands where the leaf of a door swings')
    parser.add_argument('--facts', action='store_true', help='print the figures that tests need as JSON, in metres')
    options = parser.parse_args()
    if not options.output and not options.facts:
        parser.error('nothing to do: give FILE.ifc, --facts or both')
    if options.cabinet:
        FURNISHINGS['Cabinet'] = CABINET
    if options.output:
        build().write(options.output)
    if options.facts:
        print(json.dumps(facts(), indent=1, ensure_ascii=False))


if __name__ == '__main__':
    main()
