// Messages and services of ROS 2 that the peer reads and writes, as their interface definitions have them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// The fields of a message, in their order.
#define FIELDS(...)                                                                                                    \
    template <class F> void fields(F&& each) { each(__VA_ARGS__); }

/// The name of its type in DDS.
#define TYPE(package, kind, name) static constexpr const char* TYPE = #package "::" #kind "::dds_::" #name "_";

struct Time {
    int32_t sec;
    uint32_t nanosec;
    FIELDS(sec, nanosec)
};

struct Header {
    Time stamp;
    std::string frame_id;
    FIELDS(stamp, frame_id)
};

struct Point {
    double x, y, z;
    FIELDS(x, y, z)
};

struct Quaternion {
    double x, y, z, w;
    FIELDS(x, y, z, w)
};

struct OccupancyGrid {
    TYPE(nav_msgs, msg, OccupancyGrid)
    Header header;
    Time map_load_time;
    float resolution;
    uint32_t width, height;
    Point position;
    Quaternion orientation;
    std::vector<uint8_t> data;
    FIELDS(header, map_load_time, resolution, width, height, position, orientation, data)
};

struct CostmapFilterInfo {
    TYPE(nav2_msgs, msg, CostmapFilterInfo)
    Header header;
    uint8_t type;
    std::string filter_mask_topic;
    float base, multiplier;
    FIELDS(header, type, filter_mask_topic, base, multiplier)
};

struct String {
    TYPE(std_msgs, msg, String)
    std::string data;
    FIELDS(data)
};

struct TransformStamped {
    Header header;
    std::string child_frame_id;
    Point translation;
    Quaternion rotation;
    FIELDS(header, child_frame_id, translation, rotation)
};

struct TFMessage {
    TYPE(tf2_msgs, msg, TFMessage)
    std::vector<TransformStamped> transforms;
    FIELDS(transforms)
};

/// Sixteen bytes since ROS 2 Iron.
struct Gid {
    std::array<uint8_t, 16> data;
    FIELDS(data)
};

struct NodeEntitiesInfo {
    std::string node_namespace, node_name;
    std::vector<Gid> reader_gid_seq, writer_gid_seq;
    FIELDS(node_namespace, node_name, reader_gid_seq, writer_gid_seq)
};

struct ParticipantEntitiesInfo {
    TYPE(rmw_dds_common, msg, ParticipantEntitiesInfo)
    Gid gid;
    std::vector<NodeEntitiesInfo> node_entities_info_seq;
    FIELDS(gid, node_entities_info_seq)
};

/// What a structure without members has.
struct Empty {
    uint8_t structure_needs_at_least_one_member;
    FIELDS(structure_needs_at_least_one_member)
};

struct TriggerRequest : Empty {
    TYPE(std_srvs, srv, Trigger_Request)
};

struct TriggerResponse {
    TYPE(std_srvs, srv, Trigger_Response)
    bool success;
    std::string message;
    FIELDS(success, message)
};

struct ParameterValue {
    static constexpr uint8_t INTEGER = 2, STRING = 4;
    uint8_t type;
    bool bool_value;
    int64_t integer_value;
    double double_value;
    std::string string_value;
    std::vector<uint8_t> byte_array_value, bool_array_value;
    std::vector<int64_t> integer_array_value;
    std::vector<double> double_array_value;
    std::vector<std::string> string_array_value;
    FIELDS(type, bool_value, integer_value, double_value, string_value, byte_array_value, bool_array_value,
           integer_array_value, double_array_value, string_array_value)
};

struct Parameter {
    std::string name;
    ParameterValue value;
    FIELDS(name, value)
};

struct SetParametersRequest {
    TYPE(rcl_interfaces, srv, SetParameters_Request)
    std::vector<Parameter> parameters;
    FIELDS(parameters)
};

struct SetParametersResult {
    bool successful;
    std::string reason;
    FIELDS(successful, reason)
};

struct SetParametersResponse {
    TYPE(rcl_interfaces, srv, SetParameters_Response)
    std::vector<SetParametersResult> results;
    FIELDS(results)
};

struct GoalInfo {
    std::array<uint8_t, 16> goal_id;
    Time stamp;
    FIELDS(goal_id, stamp)
};

struct CancelGoalRequest {
    TYPE(action_msgs, srv, CancelGoal_Request)
    GoalInfo goal_info;
    FIELDS(goal_info)
};

struct CancelGoalResponse {
    TYPE(action_msgs, srv, CancelGoal_Response)
    int8_t return_code;
    std::vector<GoalInfo> goals_canceling;
    FIELDS(return_code, goals_canceling)
};

struct ClearEntireCostmapRequest : Empty {
    TYPE(nav2_msgs, srv, ClearEntireCostmap_Request)
};

struct ClearEntireCostmapResponse : Empty {
    TYPE(nav2_msgs, srv, ClearEntireCostmap_Response)
};

struct ManageLifecycleNodesRequest {
    TYPE(nav2_msgs, srv, ManageLifecycleNodes_Request)
    uint8_t command;
    FIELDS(command)
};

struct ManageLifecycleNodesResponse {
    TYPE(nav2_msgs, srv, ManageLifecycleNodes_Response)
    bool success;
    FIELDS(success)
};

struct SetRouteGraphRequest {
    TYPE(nav2_msgs, srv, SetRouteGraph_Request)
    std::string graph_filepath;
    FIELDS(graph_filepath)
};

struct SetRouteGraphResponse {
    TYPE(nav2_msgs, srv, SetRouteGraph_Response)
    bool success;
    FIELDS(success)
};
