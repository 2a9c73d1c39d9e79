//! The causes of issues: one code each, with its name for people, why it matters to a robot and what the author does about it.

/// What an issue is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum IssueKind {
    /// The model is wrong or lacks something, and maps are wrong for it: of the storeys, of rooms or of ways.
    Maps,
    /// The model is wrong or lacks something, and no map is wrong for it.
    Data,
    /// No fault of the model: the building has something that this robot cannot pass.
    Building,
}

impl IssueKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Maps => "maps",
            Self::Data => "data",
            Self::Building => "building",
        }
    }
}

macro_rules! causes {
    ($($variant:ident = $name:literal, $kind:ident, $one:literal, $many:literal, $why:literal, $advice:literal;)*) => {
        /// The cause of an issue; its name is that in files.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum IssueCode {
            $(
                #[doc = $why]
                $variant,
            )*
        }

        impl IssueCode {
            /// All codes.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// Its name in files.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What it is about, where nothing else is known of an instance.
            pub fn kind(self) -> IssueKind {
                match self { $(Self::$variant => IssueKind::$kind,)* }
            }

            /// What it is, of one and of several.
            pub(crate) fn phrases(self) -> [&'static str; 2] {
                match self { $(Self::$variant => [$one, $many],)* }
            }

            /// Why it matters to a robot.
            pub(crate) fn why(self) -> &'static str {
                match self { $(Self::$variant => $why,)* }
            }

            /// What the author of the model does about it.
            pub(crate) fn advice(self) -> &'static str {
                match self { $(Self::$variant => $advice,)* }
            }
        }
    };
}

causes! {
    DoorWithoutOpening = "door_without_opening", Maps,
        "door stands in a wall without an opening", "doors stand in walls without an opening",
        "The wall goes through where the door stands: the map shows a wall, and no robot gets through.",
        "Host the door in its wall, so that the wall is cut: in Revit place it as a hosted family or pick the new host; in \
         ArchiCAD \
         place it with the door tool in the wall. A door modelled as an object or copied from another wall cuts nothing.";
    DoorBesideOpening = "door_beside_opening", Maps,
        "door stands beside its opening", "doors stand beside their openings",
        "The hole in the wall and the door that fills it are in different places: one of them is wrong on every map.",
        "Move the door and its opening together: in Revit pick the new host or reset the family's origin; in ArchiCAD check \
         the anchor \
         of the door. Where the export makes it, update the exporter and export again.";
    OpeningMissesWall = "opening_misses_wall", Maps,
        "opening misses its wall", "openings miss their walls",
        "An opening that does not lie in the wall that it voids cuts nothing: the wall stays whole on the maps.",
        "Move the opening into the wall, or host it in the wall in which it lies. In Revit rehost it (Pick New Host); in \
         ArchiCAD check \
         that the wall was not moved away from it; make the opening as deep as the wall.";
    WallNotCut = "wall_not_cut", Maps,
        "door stands in an opening that does not cut its wall", "doors stand in openings that do not cut their walls",
        "The wall stands uncut where the door is: the map shows a wall.",
        "Make the opening as deep as all layers of the wall, and host it in each wall that it passes: in Revit use Join \
         Geometry for \
         walls of several layers.";
    DoorObstructed = "door_obstructed", Maps,
        "door has an element in its way", "doors have an element in their way",
        "An element stands in the doorway and leaves less than the robot needs.",
        "Move or cut the element that stands in the doorway: furniture, mullions of a curtain wall, linings as elements of \
         their own.";
    DoorAboveFloor = "door_above_floor", Maps,
        "door begins too far above its floor", "doors begin too far above their floor",
        "The doorway begins above the floor by more than any sill: no robot gets over it.",
        "Check sill height and level of the door: in Revit the Sill Height of a door is 0; in ArchiCAD measure the sill from \
         the storey.";
    DoorWithoutFloor = "door_without_floor", Maps,
        "door has no floor at its sides", "doors have no floor at their sides",
        "There is no slab or covering before or behind the door, so that no way leads through.",
        "Model the slab or the covering under the door and on both of its sides, up to the walls.";
    DoorWithoutRoom = "door_without_room", Data,
        "door leads to no room on either side", "doors lead to no room on either side",
        "The storey has rooms, and none of them lies beside the door: it joins nothing by name.",
        "Place rooms on both sides, and let them reach to the walls: in Revit place Rooms in all enclosed areas and export \
         them as \
         IfcSpace; in ArchiCAD update the Zones.";
    DoorWidthWrong = "door_width_wrong", Data,
        "door has an OverallWidth that it cannot have", "doors have an OverallWidth that they cannot have",
        "OverallWidth disagrees with opening and body: groundplan counts what it measures, other programs do not.",
        "Correct Width and Height of the door's type; often the two are exchanged.";
    DoorWithoutWidth = "door_without_width", Data,
        "door has no OverallWidth", "doors have no OverallWidth",
        "The width is measured on opening or body, frames included: a narrow door may count as too wide or too narrow.",
        "Fill in the width of the door's type; both Revit and ArchiCAD export it as OverallWidth.";
    DoorWithoutOperation = "door_without_operation", Data,
        "door does not say how it opens", "doors do not say how they open",
        "Without OperationType a swinging door is assumed: a revolving or folding door would count as passable.",
        "Set the operation of the door's type: in Revit the type parameter Operation (IFC), in ArchiCAD the opening type.";
    DoorWithoutBody = "door_without_body", Data,
        "door has no body", "doors have no body",
        "The door is drawn by its opening alone: where its leaf hangs is not known.",
        "Export the door with its geometry: check that its category is visible in the exported view.";
    RoomWithoutDoor = "room_without_door", Maps,
        "room has no door or opening", "rooms have no door or opening",
        "No way leads into the room at all: it stays empty on the robot's plan.",
        "Model the door or the opening by which people get in. A shaft or a void is no room: give it that name, or leave it out.";
    RoomUnreachable = "room_unreachable", Maps,
        "room cannot be reached", "rooms cannot be reached",
        "The room has floor, and no way as wide as the robot leads there.",
        "Look at the ways into the room: doors, gaps between furniture and walls, and floor that is missing.";
    RoomWithoutFloor = "room_without_floor", Maps,
        "room has no floor under it", "rooms have no floor under them",
        "There is no slab or covering under the room: for a robot that is a drop, and it never gets there.",
        "Model the slab or the covering under the room up to its walls. Where the room is a void over the storey below, name \
         it so or \
         let the room below reach up through it.";
    FloorAssumed = "floor_assumed", Maps,
        "room has a floor that is only assumed", "rooms have a floor that is only assumed",
        "The model has no slab, covering or ramp there: the map assumes that the whole room has a floor.",
        "Model the slab or covering, or load the structural model together with this one.";
    StoreyFloorAssumed = "storey_floor_assumed", Maps,
        "storey has a floor that is only assumed", "storeys have a floor that is only assumed",
        "The storey has neither slabs nor rooms: what its walls enclose is taken for floor, holes included.",
        "Model the slabs of the storey, or load the structural model together with this one.";
    StoreyWithoutFloor = "storey_without_floor", Maps,
        "storey has no floor", "storeys have no floor",
        "The storey has neither slabs nor rooms nor walls that enclose anything: its map has no free cell.",
        "Model slabs, walls and rooms of the storey, or load the files that have them together with this one.";
    FloorGap = "floor_gap", Maps,
        "gap in a floor", "gaps in floors",
        "Part of a room has no slab under it, and no stair, shaft or void explains it: for a robot that is a drop.",
        "Extend the slabs until they meet each other and the walls, or cut real holes by an opening in the slab.";
    FloorWithoutRoom = "floor_without_room", Data,
        "enclosed floor belongs to no room", "enclosed floors belong to no room",
        "Walls enclose floor that no room covers: it has no name and no waypoint, and cannot be closed by the schedule.",
        "Place a room there: in Revit a Room in every enclosed area, in ArchiCAD a Zone.";
    WallGap = "wall_gap", Maps,
        "wall does not meet its neighbour", "walls do not meet their neighbours",
        "A gap is left at the end of the wall, between two rooms or to the outside: the map leaks there, and a lidar sees \
         through.",
        "Extend the wall until it meets the other one: in Revit Trim/Extend and Join Geometry, in ArchiCAD let the reference \
         lines meet.";
    RoomsOverlap = "rooms_overlap", Maps,
        "room overlaps another one", "rooms overlap other ones",
        "The same floor belongs to two rooms: which of them is closed, scanned or named there is not defined.",
        "Separate the rooms by walls or separation lines; delete rooms that were placed twice; model gross areas as GFA.";
    RoomWithoutBody = "room_without_body", Maps,
        "room has no geometry", "rooms have no geometry",
        "A room without geometry is on no map and gets no waypoint.",
        "In Revit a Room that is not placed or not enclosed has no geometry: place or delete it, and export 3D rooms; in \
         ArchiCAD update \
         the Zones.";
    RoomNotMapped = "room_not_mapped", Maps,
        "room is on no map", "rooms are on no map",
        "No storey with a floor lies at the height of the room.",
        "Check base and level of the room: its floor has to lie on the slab of its storey.";
    StoreyNotMapped = "storey_not_mapped", Maps,
        "storey with rooms or doors has no map", "storeys with rooms or doors have no map",
        "The storey holds rooms or doors, and nothing to walk on.",
        "Model the floor of the storey, or move its rooms and doors to the storey where they are.";
    StoreysApart = "storeys_apart", Maps,
        "storey is not joined with the others", "storeys are not joined with the others",
        "No stair, ramp or lift leads to the storey: no way over storeys can be planned.",
        "Model the stair, ramp or lift with IfcStair, IfcRamp or IfcTransportElement from floor to floor; its flights have to \
         begin and \
         end at the floors.";
    StoreyElevation = "storey_elevation", Data,
        "storey lies at another height than its floor", "storeys lie at another height than their floors",
        "The placement of the storey and its slabs disagree: heights that people type in are wrong by as much.",
        "Set the elevation of the level to its finished floor: in Revit move the Level, in ArchiCAD edit the Storey Settings.";
    ElementOnOtherStorey = "element_on_other_storey", Data,
        "element is listed on another storey than it stands on", "elements are listed on another storey than they stand on",
        "Maps place elements by their height; lists and schedules by storey have them on the wrong one.",
        "Set the level of the element (Revit: Level or Base Constraint; ArchiCAD: Home Storey) to that on which it stands.";
    DuplicateElement = "duplicate_element", Data,
        "element stands twice in one place", "elements stand twice in one place",
        "Two elements of a class have the same body: if the schedule removes one, the other stays on the maps.",
        "Delete the copy: in Revit look at the warning \"identical instances in the same place\"; check for files that are \
         linked twice.";
    DuplicateGlobalId = "duplicate_global_id", Maps,
        "element has the GlobalId of another one", "elements have the GlobalId of another one",
        "Semantic maps, schedules and reports name elements by GlobalId: one of the two cannot be named.",
        "Export again with new GlobalIds for copied elements; in Revit reset the parameter IfcGUID of the copies.";
    GeometryFailed = "geometry_failed", Maps,
        "element has a body that cannot be made", "elements have a body that cannot be made",
        "A box stands on the maps in place of the element, or nothing at all.",
        "Check the body for faces that cross or are open; model it anew, or export it as extrusion or triangles.";
    GeometryDoubtful = "geometry_doubtful", Maps,
        "element has a body that is incomplete or doubtful", "elements have a body that is incomplete or doubtful",
        "Part of the body, or a cut in it, could not be made as the file says.",
        "Simplify the body; use openings instead of boolean operations on bodies.";
    ElementOutOfReach = "element_out_of_reach", Maps,
        "element lies far from the building or cannot be placed", "elements lie far from the building or cannot be placed",
        "The element is left out of the maps, because its placement cannot be right.",
        "Move or delete it: often something was left at the origin of the project, or placed with coordinates of the survey.";
    NotDrawn = "not_drawn", Maps,
        "element is of no kind that maps know", "elements are of no kind that maps know",
        "The file does not say what the element is, so that it is on no map.",
        "Export it with the class that it has (IfcWall, IfcFurniture ..) instead of IfcProxy or IfcBuildingElementProxy.";
    GroundDoubtful = "ground_doubtful", Maps,
        "ground outdoors is incomplete", "grounds outdoors are incomplete",
        "Part of the terrain or of its cuts could not be used: the map of the outdoors differs.",
        "Export the terrain as one triangulated surface without faces above each other.";
    NoGeoreference = "no_georeference", Data,
        "model without a georeference", "models without a georeference",
        "Without IfcMapConversion nothing can be given in coordinates of the survey or as latitude and longitude.",
        "Set survey point and coordinate system, and export the map conversion (Revit: Shared Coordinates; ArchiCAD: Survey \
         Point).";
    GeoreferenceDoubtful = "georeference_doubtful", Data,
        "georeference that cannot be right", "georeferences that cannot be right",
        "The map conversion contradicts itself or that of another file.",
        "Check eastings, northings, scale and unit of the map conversion.";
    NoDates = "no_dates", Data,
        "model without dates and activity numbers", "models without dates and activity numbers",
        "All maps show everything built: the model has no tasks, no element has a date, and none the number of an activity.",
        "Link the elements with the schedule: fill in a property Activity ID, or give planners a table; see `groundplan link`.";
    ScheduleDoubtful = "schedule_doubtful", Data,
        "doubt about the schedule", "doubts about the schedule",
        "A date, task or link of the schedule cannot be used as it is written: maps of that date may be wrong.",
        "Correct the task or the date in the planner's file; `groundplan tasks` lists all of them.";
    StairDoubtful = "stair_doubtful", Data,
        "stair has a measure that its body contradicts", "stairs have a measure that their bodies contradict",
        "What is measured on the body counts; other programs take the figure of the file.",
        "Correct riser height and tread length of the stair's type.";
    FileDoubtful = "file_doubtful", Data,
        "doubt about the file", "doubts about the file",
        "Something in the file is not as IFC has it; what it means was guessed or left out.",
        "Export the file again with a current exporter.";
    DoorTooNarrow = "door_too_narrow", Building,
        "door is too narrow for this robot", "doors are too narrow for this robot",
        "The clear width is less than the robot and its margin need.",
        "No fault of the model: check the width; otherwise the robot has to be smaller.";
    DoorNotOpened = "door_not_opened", Building,
        "door is of a kind that this robot does not open", "doors are of a kind that this robot does not open",
        "By its profile the robot does not get through doors of this operation.",
        "No fault of the model: see `opens` of the robot's profile.";
    DoorWithSill = "door_with_sill", Building,
        "door has a sill that is higher than a step of this robot", "doors have a sill that is higher than a step of this robot",
        "The doorway begins above the floor by more than the robot climbs.",
        "No fault of the model, if the sill is there.";
    DoorOfLift = "door_of_lift", Building,
        "door leads into a lift", "doors lead into a lift",
        "A lift is an obstacle on the map of its storey; ways over storeys take it where the robot does.",
        "No fault of the model.";
    DoorNeedsResolution = "door_needs_resolution", Building,
        "door is closed by the resolution of the maps", "doors are closed by the resolution of the maps",
        "The cells are too coarse for the width of the doorway.",
        "No fault of the model: draw the maps with `--resolution 0.025`.";
    DoorInWork = "door_in_work", Building,
        "door is being worked on", "doors are being worked on",
        "At this date the door is being hung or taken down.",
        "No fault of the model.";
    RoomBehind = "room_behind", Building,
        "room lies behind what this robot cannot pass", "rooms lie behind what this robot cannot pass",
        "Between the robot and the room is something narrower than the robot, or closed to it.",
        "No fault of the model, if the way is so narrow.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_word_of_its_own() {
        let mut names: Vec<_> = IssueCode::ALL.iter().map(|code| code.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), IssueCode::ALL.len());
    }
}
