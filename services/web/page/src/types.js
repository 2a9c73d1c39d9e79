// Types of the documents and of the store, for `tsc` alone: no module imports anything of them while the page runs.
// The documents are written by services/web/src/documents and services/web/src/live; keys end with their unit, and what there is
// not is null. GlobalIds and indexes of storeys are the keys of records.

/** @typedef {[number, number]} Point x and y, metres in the frame of the maps. */
/** @typedef {Point[][][]} MultiPolygon polygons, each of its outer ring and its holes. */
/** @typedef {{x0: number, y0: number, x1: number, y1: number}} Box metres. */

/**
 * @typedef {object} Storey
 * @property {number} index
 * @property {string | null} name
 * @property {number} floor_z_m
 * @property {string} floor `built` or `assumed`
 * @property {Point} origin_m lower left corner
 * @property {[number, number]} size_cells width and height
 */

/**
 * @typedef {object} DateStop a date that can be shown
 * @property {string | null} key names its document; null where only the daemons can show it
 * @property {string | null} at plan time; null where everything is built
 * @property {string | null} until the next change
 */

/**
 * @typedef {object} SiteElement
 * @property {string} type IFC entity
 * @property {string} class
 * @property {string | null} name
 * @property {number[]} storeys
 * @property {Record<string, MultiPolygon>} footprints by storey
 * @property {{min: [number, number, number], max: [number, number, number]} | null} aabb_m
 * @property {Record<string, any>} schedule
 * @property {Record<string, any>} attributes
 */

/**
 * @typedef {object} Space
 * @property {string | null} name
 * @property {string | null} long_name
 * @property {number | null} storey
 * @property {number} area_m2
 * @property {number} height_m
 * @property {number} floor_z_m
 * @property {MultiPolygon} polygon_m
 * @property {Record<string, Record<string, any>>} property_sets
 * @property {string | null} predefined_type
 * @property {boolean} external
 */

/**
 * @typedef {object} Finding
 * @property {string} code
 * @property {string | null} text
 * @property {string | null} global_id
 * @property {string | null} name
 * @property {string | null} place
 */

/** @typedef {{n: number, list: Finding[]}} Listed */

/**
 * @typedef {object} Site data/site.json
 * @property {string} title
 * @property {boolean} live true if the dates move by themselves
 * @property {boolean} control true if viewers may change the date and confirm
 * @property {{file: string, sha256?: string}[]} sources
 * @property {{file: string, sha256?: string}[] | null} schedule_sources
 * @property {boolean} schedule_ignored
 * @property {number} resolution_m
 * @property {Record<string, any> | null} robot
 * @property {Record<string, any>} frames how they lie to each other
 * @property {{size: number, levels: number, origin_m: Point}} tiles size in pixels; the origin is the upper left corner
 * @property {Storey[]} storeys
 * @property {DateStop[]} dates
 * @property {Record<string, SiteElement>} elements
 * @property {Record<string, Space>} spaces
 * @property {Record<string, {name: string}>} tasks
 * @property {number | null} entrance index of a storey
 * @property {Record<"errors" | "warnings" | "assumptions" | "substitutions" | "left_out", Listed>} findings
 */

/**
 * @typedef {object} Task
 * @property {string} global_id
 * @property {string | null} identification
 * @property {string | null} name
 * @property {string | null} file
 * @property {string | null} parent GlobalId of the task that it is nested in
 * @property {number} depth
 * @property {boolean} is_summary
 * @property {string | null} start
 * @property {string | null} finish
 * @property {string | null} dates_from
 * @property {number | null} total_float_h
 * @property {number | null} completion
 * @property {{global_id: string, operation: string}[]} elements
 * @property {{global_id: string}[]} spaces
 * @property {{message: string}[]} warnings
 */

/** @typedef {{start: string | null, finish: string | null}} ProgressDates */
/** @typedef {{planned: ProgressDates | null, reported: ProgressDates | null}} TaskProgress */
/** @typedef {{planned: ProgressDates, reported: ProgressDates | null, observed: ProgressDates | null}} ElementProgress */

/**
 * @typedef {object} Tasks data/tasks.json
 * @property {"schedule" | "elements"} known_from
 * @property {Task[]} tasks
 * @property {{tasks: Record<string, TaskProgress>, elements: Record<string, ElementProgress>} | null} progress
 */

/** @typedef {{free_m2: number | null, rooms: Record<string, {n: number, area_m2: number}>}} Areas */
/** @typedef {{storeys: Record<string, Areas>, sum: Areas, tasks: Record<string, string>}} Summary data/summary/KEY.json */
/** @typedef {{classes: string[], states: string[], task: string | null, storey: boolean}} Filter empty lists let everything through */
/** @typedef {{x: number, y: number, snap: "corner" | "cell", of: string | null}} MeasuredPoint metres; of what the corner is */

/** @typedef {[number, string][]} States the first state and every change, each with the number of its date. */
/** @typedef {{elements: Record<string, States>, spaces: Record<string, States>}} Calendar data/calendar.json */

/**
 * @typedef {object} Waypoint
 * @property {number} id
 * @property {"scan" | "centre"} kind
 * @property {string | null} name
 * @property {string | null} space GlobalId
 * @property {number} storey
 * @property {number} order place in the tour
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} z_m
 * @property {number} yaw_rad
 * @property {number} [sensor_z_m]
 * @property {number} leg_m
 * @property {number} clearance_m
 * @property {number} covers_m2
 */

/**
 * @typedef {object} GraphNode
 * @property {number} id
 * @property {string} kind
 * @property {string | null} of GlobalId of what it stands for
 * @property {string | null} space GlobalId of the space that it lies in
 * @property {number} storey
 * @property {number} x_m
 * @property {number} y_m
 */

/**
 * @typedef {object} GraphEdge
 * @property {number} from
 * @property {number} to
 * @property {string} class
 * @property {string | null} of
 * @property {boolean} usable
 * @property {number} length_m
 * @property {Point[]} line_m
 */

/** @typedef {{nodes: GraphNode[], edges: GraphEdge[]}} Graph */

/**
 * @typedef {object} SpaceAtDate
 * @property {"reached" | "no_way" | "blocked" | "open"} state
 * @property {string[]} why codes of why the schedule closes it
 * @property {string | null} no_way why no way leads there
 * @property {number | null} coverage
 * @property {string | null} reason why it has no waypoint
 * @property {string | null} door
 */

/**
 * @typedef {object} DateDocument data/dates/KEY.json
 * @property {string} key
 * @property {string | null} at
 * @property {string | null} until
 * @property {{index: number, status: string, layers: Record<string, string>}[]} storeys layers by name, with their hashes
 * @property {string | null} model hash of what stands, as a GLB
 * @property {Record<string, string>} elements states of those that are not built
 * @property {Record<string, SpaceAtDate>} spaces
 * @property {Record<string, Record<string, string>>} passages of doors, by storey
 * @property {{global_id: string, reasons: {text: string}[]}[]} doors
 * @property {Waypoint[]} waypoints
 * @property {Mission} mission
 * @property {Record<string, string | null>} entries by storey
 * @property {Graph} graph
 */

/**
 * @typedef {object} Mission
 * @property {number | null} coverage
 * @property {number} coverage_goal
 * @property {{scans: number, coverage: number}[]} curve
 * @property {number} scans
 * @property {number} connecting_scans
 * @property {number} mission_s
 * @property {number} driving_s
 * @property {number} scanning_s
 */

/** @typedef {{key: string, at: string | null, stop: number | null}} LiveDate */
/** @typedef {{name: string, state: "ok" | "warning" | "error" | "down", detail: string | null}} Service */
/** @typedef {{services: Service[], stale: boolean, why: string | null}} Status */
/** @typedef {{storey: number, x_m: number, y_m: number, yaw_rad: number, sigma_m: number, sigma_deg: number, age_s: number | null}} Robot */
/** @typedef {{storey: number, x_m: number, y_m: number, yaw_rad: number}} FleetPlace */
/** @typedef {{name: string, state: "current" | "behind" | "silent" | "never_heard", here: boolean, findings: string[], place: FleetPlace | null, epoch: number | null, plan_time: string | null}} FleetRobot */
/** @typedef {{error: string | null, epoch?: number, robots: FleetRobot[], conflicts?: {id: string, told: string}[], n_elements?: number}} Fleet */
/** @typedef {{hash: string, storey: number, resolution_m: number, size: [number, number], corners_m: [Point, Point, Point], sigma_m: number, sigma_deg: number}} Slam lower left, lower right and upper left corner */
/** @typedef {{verdict: string, observation: string, text: string}} Deviation */
/** @typedef {{elements: Record<string, Deviation>, waiting: string[], storey: number}} Deviations */

/** @typedef {{x: number, y: number, half: number, height: number}} LabelPlace middle, half of the free width, and the height; metres */

/**
 * @typedef {object} Feature what lies on a storey
 * @property {string} id GlobalId
 * @property {"room" | "element"} kind
 * @property {string} class
 * @property {MultiPolygon} polygon
 * @property {Box} box
 * @property {number} area
 * @property {Path2D | null} path kept by what draws it
 * @property {LabelPlace | null} label kept by what writes there
 */

/**
 * @typedef {object} Pen what painters draw with: pixels of the canvas, or metres of the maps
 * @property {CanvasRenderingContext2D} ctx
 * @property {number} scale pixels per metre
 * @property {(metres: number) => number} x
 * @property {(metres: number) => number} y
 * @property {import("leaflet").Point} size pixels
 * @property {(name: string) => string} colour of the style sheet
 * @property {() => void} redraw asks for another drawing
 * @property {() => void} pixels draws in pixels from here on
 * @property {() => void} metres draws in metres from here on
 * @property {Box} box what is seen
 */

/**
 * @typedef {object} Way over the route graph
 * @property {number} length_m
 * @property {GraphNode[]} nodes
 * @property {{edge: GraphEdge, storeys: number[]}[]} edges
 * @property {string[]} doors
 * @property {string[]} rooms
 */

/** @typedef {{path: string[], answer: any, text: string}} Told an answer of a live site: for programs, null if there is none, and for people */

/**
 * @typedef {object} DrawnWay
 * @property {{edge: {line_m: Point[]}, storeys: number[]}[] | null} edges null if there is no way
 * @property {{storey: number, x_m: number, y_m: number}[]} nodes from the beginning to the end; none without a way
 * @property {string[]} closed GlobalIds of doors and rooms that close it
 */

/** @typedef {{kind: "door", id: string, passage: string} | {kind: "room", id: string} | {kind: "edge", edge: GraphEdge, a: string, b: string}} Obstacle */

/**
 * @typedef {object} State
 * @property {Site | null} site
 * @property {Calendar | null} calendar
 * @property {DateDocument | null} doc document of the date shown
 * @property {DateDocument | null} previousDoc the one shown before it (live: there the calendar may be empty)
 * @property {number | null} storey
 * @property {string | null} date key of the date wanted; doc.key once it is loaded
 * @property {number | null} stop index into site.dates, null between the stops of a live site
 * @property {string[]} layers
 * @property {string | null} select GlobalId of a room or an element
 * @property {number | null} waypoint id of the waypoint chosen in the mission
 * @property {"plan" | "3d"} view
 * @property {Point | null} centre middle of the plan in metres; null while all of the storey is shown
 * @property {number | null} zoom
 * @property {number[] | null} camera 3D: [x, y, z] of the camera and of what it looks at; null before anybody moved it
 * @property {number | null} cut 3D: height of the cut that was chosen; null for that of the storey
 * @property {string | null} from GlobalId of a room, or of a live site `x,y,storey` in metres
 * @property {string | null} to
 * @property {"from" | "to" | "from-room" | "to-room" | null} picking the end that the next click on the plan sets, to a point or to a room
 * @property {Told | null} about the answer about the room or door selected
 * @property {Told | null} wayAnswer
 * @property {string} tab
 * @property {string | null} sheet phones: which panel is open below the plan
 * @property {boolean} calendarOpen
 * @property {boolean} playing
 * @property {boolean} connected live: what the events told last
 * @property {boolean} full live: there are too many viewers for this one
 * @property {Status | null} status
 * @property {Robot | null} robot
 * @property {Fleet | null} fleet of a server with a link to its robots
 * @property {Slam | null} slam
 * @property {boolean} slamShown
 * @property {Deviations | null} deviations
 * @property {Tasks | null} tasks null until somebody wants them
 * @property {{key: string, doc: Summary} | null} summary of the date with that key
 * @property {string | null} task GlobalId of the task chosen
 * @property {number | null} look weeks to look ahead; null for all tasks
 * @property {string | null} compare the date compared with; null for the one before
 * @property {DateDocument | null} compareDoc its document, of files
 * @property {Filter} filter
 * @property {string[]} hidden GlobalIds
 * @property {string[]} only GlobalIds of what alone is shown; empty for everything
 * @property {boolean} byState colours of states in 3D
 * @property {boolean} measuring
 * @property {MeasuredPoint[]} measured at most two
 */

export {};
