// A peer of ros-bridge in the ROS 2 graph, with Fast DDS and without ROS: prints what the bridge publishes.
//
// usage: peer [--domain N] [--namespace /groundplan] [--publish-slam-map FILE.yaml] [--topic /map] [--volatile]
//             [--nav2] [--call SERVICE] [--set NAME=VALUE]
//
// Each message is one JSON line: topic, frame, and what a person wants to know of it.
// --publish-slam-map  it is the robot: it publishes a map of a map server as SLAM would, once a second; latched, or --volatile
// --nav2              it is Nav2: it answers the calls by which it is stopped, loaded and resumed
// --call, --set       it calls next_change, align or confirm, or sets a parameter, once, and prints the answer

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <exception>
#include <functional>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <openssl/evp.h>

#include "map_file.hpp"
#include "messages.hpp"
#include "node.hpp"

namespace {

using Clock = std::chrono::steady_clock;

struct Arguments {
    uint32_t domain = 0;
    std::string own = "/groundplan";
    std::string slam_map;
    std::string slam_topic = "/map";
    Qos slam_qos = LATCHED;
    bool is_nav2 = false;
    std::vector<std::string> calls;
    std::vector<std::string> parameters;
};

std::string quoted(const std::string& text)
{
    std::ostringstream json;
    json << '"';
    for (const unsigned char c : text) {
        if (c == '"' || c == '\\') {
            json << '\\' << c;
        } else if (c < 0x20) {
            json << "\\u" << std::hex << std::setw(4) << std::setfill('0') << int{c};
        } else {
            json << c;
        }
    }
    json << '"';
    return json.str();
}

std::string number(double value)
{
    std::ostringstream json;
    json << std::setprecision(17) << value;
    return json.str();
}

/// A line of a topic; `members` are those of a JSON object without its braces.
void print(const std::string& topic, const std::string& members)
{
    std::cout << "{\"topic\":" << quoted(topic) << (members.empty() ? "" : ",") << members << '}' << std::endl;
}

std::string sha256(const std::vector<uint8_t>& bytes)
{
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned length = 0;
    EVP_Digest(bytes.data(), bytes.size(), digest, &length, EVP_sha256(), nullptr);
    std::ostringstream hex;
    for (unsigned k = 0; k < length; ++k) {
        hex << std::hex << std::setw(2) << std::setfill('0') << int{digest[k]};
    }
    return hex.str();
}

std::string shown(const OccupancyGrid& grid)
{
    const auto count = [&grid](uint8_t cell) { return std::count(grid.data.begin(), grid.data.end(), cell); };
    std::ostringstream json;
    json << "\"frame\":" << quoted(grid.header.frame_id) << ",\"size\":[" << grid.width << ',' << grid.height
         << "],\"resolution_m\":" << number(std::round(grid.resolution * 1e7) / 1e7) << ",\"origin_m\":["
         << number(grid.position.x) << ',' << number(grid.position.y) << "],\"free\":" << count(0)
         << ",\"occupied\":" << count(100) << ",\"unknown\":" << count(255) << ",\"sha256\":\"" << sha256(grid.data) << '"';
    return json.str();
}

std::string shown(const CostmapFilterInfo& info)
{
    return "\"frame\":" + quoted(info.header.frame_id) + ",\"type\":" + std::to_string(info.type) +
           ",\"mask\":" + quoted(info.filter_mask_topic) + ",\"base\":" + number(info.base) +
           ",\"multiplier\":" + number(info.multiplier);
}

/// The members of the JSON document that a message is.
std::string shown(const String& message)
{
    std::string json = message.data;
    std::replace(json.begin(), json.end(), '\n', ' ');
    const auto begin = json.find('{'), end = json.rfind('}');
    if (begin == std::string::npos || end == std::string::npos || end < begin) {
        return "\"text\":" + quoted(message.data);
    }
    return json.substr(begin + 1, end - begin - 1);
}

std::string shown(const TFMessage& message)
{
    std::string json;
    for (const auto& transform : message.transforms) {
        const auto& q = transform.rotation;
        json += (json.empty() ? "" : ",") + ("{\"parent\":" + quoted(transform.header.frame_id)) +
                ",\"child\":" + quoted(transform.child_frame_id) + ",\"x_m\":" + number(transform.translation.x) +
                ",\"y_m\":" + number(transform.translation.y) + ",\"yaw_rad\":" + number(2 * std::atan2(q.z, q.w)) + '}';
    }
    return "\"transforms\":[" + json + ']';
}

std::string shown(const ParticipantEntitiesInfo& participant)
{
    std::string json;
    for (const auto& node : participant.node_entities_info_seq) {
        const std::string folder = node.node_namespace == "/" ? "" : node.node_namespace;
        json += (json.empty() ? "" : ",") + quoted(folder + '/' + node.node_name);
    }
    return "\"nodes\":[" + json + ']';
}

std::string answered(const TriggerResponse& response)
{
    return std::string("\"success\":") + (response.success ? "true" : "false") + ",\"message\":" + quoted(response.message);
}

std::string answered(const SetParametersResponse& response)
{
    const auto& result = response.results.at(0);
    return std::string("\"success\":") + (result.successful ? "true" : "false") + ",\"message\":" + quoted(result.reason);
}

std::string asked(const SetRouteGraphRequest& request) { return ",\"file\":" + quoted(request.graph_filepath); }
std::string asked(const ManageLifecycleNodesRequest& request) { return ",\"command\":" + std::to_string(request.command); }
template <class Request> std::string asked(const Request&) { return ""; }

ParameterValue value_of(const std::string& text)
{
    ParameterValue value{};
    const bool is_number = !text.empty() && text.find_first_not_of("0123456789", text[0] == '-') == std::string::npos;
    value.type = is_number ? ParameterValue::INTEGER : ParameterValue::STRING;
    (is_number ? void(value.integer_value = std::stoll(text)) : void(value.string_value = text));
    return value;
}

/// The node and what it does again and again.
class Peer {
public:
    explicit Peer(const Arguments& arguments) : node(arguments.domain, "fast_dds_peer")
    {
        show<ParticipantEntitiesInfo>("ros_discovery_info", "ros_discovery_info", LATCHED);
        for (const char* grid : {"/map", "/localization_map", "/keepout_mask"}) {
            show<OccupancyGrid>("rt" + arguments.own + grid, arguments.own + grid, LATCHED);
        }
        show<CostmapFilterInfo>("rt" + arguments.own + "/keepout_info", arguments.own + "/keepout_info", LATCHED);
        show<String>("rt" + arguments.own + "/changed", arguments.own + "/changed", LATCHED);
        show<String>("rt" + arguments.own + "/heartbeat", arguments.own + "/heartbeat", VOLATILE);
        show<TFMessage>("rt/tf_static", "/tf_static", LATCHED);
        if (!arguments.slam_map.empty()) {
            publish_each_second(arguments);
        }
        if (arguments.is_nav2) {
            serve_as_nav2();
        }
        for (const auto& name : arguments.calls) {
            call<TriggerResponse>(arguments.own + '/' + name, TriggerRequest{});
        }
        for (const auto& text : arguments.parameters) {
            const auto at = text.find('=');
            const Parameter parameter{text.substr(0, at), value_of(text.substr(std::min(at, text.size() - 1) + 1))};
            call<SetParametersResponse>(arguments.own + "/ros_bridge/set_parameters", SetParametersRequest{{parameter}});
        }
        node.announce();
    }

    void spin()
    {
        for (const auto& [topic, step] : steps) {
            try {
                step();
            } catch (const std::exception& why) {
                print(topic, "\"error\":" + quoted(why.what()));
            }
        }
    }

private:
    Node node;
    std::vector<std::pair<std::string, std::function<void()>>> steps;
    // Their addresses stay.
    std::deque<Server> servers;
    std::deque<Client> clients;

    template <class M> void show(const std::string& dds_name, const std::string& topic, Qos qos)
    {
        auto& reader = node.reader(dds_name, M::TYPE, qos);
        steps.emplace_back(topic, [topic, &reader] {
            while (auto sample = take(reader)) {
                print(topic, shown(cdr::decode<M>(sample->bytes)));
            }
        });
    }

    void publish_each_second(const Arguments& arguments)
    {
        auto& writer = node.writer("rt" + arguments.slam_topic, OccupancyGrid::TYPE, arguments.slam_qos);
        auto message = cdr::encode(read_map(arguments.slam_map));
        steps.emplace_back(arguments.slam_topic, [&writer, message, due = Clock::now()]() mutable {
            if (Clock::now() >= due) {
                writer.write(&message);
                due += std::chrono::seconds(1);
            }
        });
    }

    /// Answers all calls of a service alike.
    template <class Request, class Response> void serve(const std::string& name, const Response& response)
    {
        auto& server = servers.emplace_back(node, name, Request::TYPE, Response::TYPE);
        steps.emplace_back(name, [name, &server, response] {
            while (auto request = server.request()) {
                server.answer(*request, cdr::encode(response));
                print(name, "\"called\":true" + asked(cdr::decode<Request>(request->bytes)));
            }
        });
    }

    void serve_as_nav2()
    {
        for (const std::string action : {"navigate_to_pose", "navigate_through_poses", "follow_waypoints"}) {
            serve<CancelGoalRequest>('/' + action + "/_action/cancel_goal", CancelGoalResponse{});
        }
        for (const std::string costmap : {"global_costmap", "local_costmap"}) {
            serve<ClearEntireCostmapRequest>('/' + costmap + "/clear_entirely_" + costmap, ClearEntireCostmapResponse{});
        }
        serve<SetRouteGraphRequest>("/route_server/set_route_graph", SetRouteGraphResponse{true});
        const std::string manager = "/lifecycle_manager_navigation";
        serve<ManageLifecycleNodesRequest>(manager + "/manage_nodes", ManageLifecycleNodesResponse{true});
    }

    /// Calls a service once, as soon as it is there, and prints the answer.
    template <class Response, class Request> void call(const std::string& name, const Request& request)
    {
        auto& client = clients.emplace_back(node, name, Request::TYPE, Response::TYPE);
        steps.emplace_back(name, [name, &client, request, is_called = false]() mutable {
            if (!is_called && client.is_there()) {
                client.call(cdr::encode(request));
                is_called = true;
            }
            if (auto response = client.response()) {
                print(name, answered(cdr::decode<Response>(response->bytes)));
            }
        });
    }
};

Arguments arguments_of(int count, char** words)
{
    Arguments arguments;
    for (int k = 1; k < count; ++k) {
        const std::string name = words[k];
        const auto value = [&]() -> std::string {
            if (++k == count) {
                throw std::invalid_argument(name + " needs a value");
            }
            return words[k];
        };
        if (name == "--domain") {
            arguments.domain = static_cast<uint32_t>(std::stoul(value()));
        } else if (name == "--namespace") {
            arguments.own = value();
        } else if (name == "--publish-slam-map") {
            arguments.slam_map = value();
        } else if (name == "--topic") {
            arguments.slam_topic = value();
        } else if (name == "--volatile") {
            arguments.slam_qos = VOLATILE;
        } else if (name == "--nav2") {
            arguments.is_nav2 = true;
        } else if (name == "--call") {
            arguments.calls.push_back(value());
        } else if (name == "--set") {
            arguments.parameters.push_back(value());
        } else {
            throw std::invalid_argument(name + " is no argument, see the beginning of peer.cpp");
        }
    }
    return arguments;
}

} // namespace

int main(int count, char** words)
{
    try {
        Peer peer(arguments_of(count, words));
        for (;;) {
            peer.spin();
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    } catch (const std::exception& why) {
        std::cerr << "peer: " << why.what() << '\n';
        return 2;
    }
}
