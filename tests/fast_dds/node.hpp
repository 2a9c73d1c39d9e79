// A node of ROS 2 as rmw_fastrtps makes it: a participant with readers, writers, servers and clients.
#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include "cdr.hpp"
#include "messages.hpp"

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

/// Reliable, of so many messages; latched or not.
struct Qos {
    bool is_latched;
    int depth;
};
constexpr Qos LATCHED{true, 1};
constexpr Qos VOLATILE{false, 1};
/// As rmw_qos_profile_services_default.
constexpr Qos SERVICE{false, 10};

/// A message and what came with it.
struct Sample {
    cdr::Bytes bytes;
    fast::SampleInfo info;
};

inline std::optional<Sample> take(fast::DataReader& reader)
{
    Sample sample;
    while (reader.take_next_sample(&sample.bytes, &sample.info) == ReturnCode_t::RETCODE_OK) {
        if (sample.info.valid_data) {
            return sample;
        }
    }
    return std::nullopt;
}

inline Gid gid_of(const rtps::GUID_t& guid)
{
    Gid gid{};
    std::copy_n(guid.guidPrefix.value, 12, gid.data.begin());
    std::copy_n(guid.entityId.value, 4, gid.data.begin() + 12);
    return gid;
}

class Node {
public:
    Node(uint32_t domain, const std::string& name) : name(name)
    {
        fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
        const std::string enclave = "enclave=/;";
        qos.name("/");
        qos.user_data().data_vec({enclave.begin(), enclave.end()});
        auto& builtin = qos.wire_protocol().builtin;
        builtin.readerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
        builtin.writerHistoryMemoryPolicy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
        // Shared memory, the other transport of rmw_fastrtps, would stay when the process is killed; the bridge does not use it.
        qos.transport().use_builtin_transports = false;
        qos.transport().user_transports.push_back(std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>());
        participant = made(fast::DomainParticipantFactory::get_instance()->create_participant(domain, qos), "participant");
        publisher = made(participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT), "publisher");
        subscriber = made(participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT), "subscriber");
    }

    /// A reader of messages of a topic; `dds_name` is the name with its prefix.
    fast::DataReader& reader(const std::string& dds_name, const char* type, Qos asked)
    {
        fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
        qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
        qos.data_sharing().off();
        set(qos, asked);
        auto* reader = made(subscriber->create_datareader(topic(dds_name, type), qos), dds_name);
        entities.reader_gid_seq.push_back(gid_of(reader->guid()));
        return *reader;
    }

    /// A writer of messages of a topic; `dds_name` is the name with its prefix.
    fast::DataWriter& writer(const std::string& dds_name, const char* type, Qos asked)
    {
        fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
        qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
        qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
        qos.data_sharing().off();
        set(qos, asked);
        auto* writer = made(publisher->create_datawriter(topic(dds_name, type), qos), dds_name);
        entities.writer_gid_seq.push_back(gid_of(writer->guid()));
        return *writer;
    }

    /// Tells the graph of the node and what it has.
    void announce()
    {
        auto& graph = writer("ros_discovery_info", ParticipantEntitiesInfo::TYPE, LATCHED);
        entities.node_namespace = "/";
        entities.node_name = name;
        auto bytes = cdr::encode(ParticipantEntitiesInfo{gid_of(participant->guid()), {entities}});
        graph.write(&bytes);
    }

private:
    std::string name;
    NodeEntitiesInfo entities;
    fast::DomainParticipant* participant;
    fast::Publisher* publisher;
    fast::Subscriber* subscriber;

    template <class T> static T* made(T* entity, const std::string& what)
    {
        if (entity == nullptr) {
            throw std::runtime_error("Fast DDS creates no " + what);
        }
        return entity;
    }

    template <class Q> static void set(Q& qos, Qos asked)
    {
        qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
        qos.durability().kind = asked.is_latched ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
        qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
        qos.history().depth = asked.depth;
    }

    fast::Topic* topic(const std::string& dds_name, const char* type)
    {
        if (auto* there = participant->lookup_topicdescription(dds_name)) {
            return dynamic_cast<fast::Topic*>(there);
        }
        fast::TypeSupport(new cdr::Type(type)).register_type(participant);
        return made(participant->create_topic(dds_name, type, fast::TOPIC_QOS_DEFAULT), dds_name);
    }
};

/// A service that a node offers.
class Server {
public:
    Server(Node& node, const std::string& name, const char* request_type, const char* response_type)
        : requests(node.reader("rq" + name + "Request", request_type, SERVICE)),
          responses(node.writer("rr" + name + "Reply", response_type, SERVICE))
    {
    }

    std::optional<Sample> request() { return take(requests); }

    /// Answers a request with the identity by which its client knows it: of the reader of its responses, if it told that.
    void answer(const Sample& request, cdr::Bytes response)
    {
        rtps::WriteParams params;
        params.related_sample_identity() = request.info.sample_identity;
        const auto& reader = request.info.related_sample_identity.writer_guid();
        if (reader != rtps::GUID_t::unknown()) {
            params.related_sample_identity().writer_guid() = reader;
        }
        responses.write(&response, params);
    }

private:
    fast::DataReader& requests;
    fast::DataWriter& responses;
};

/// A service that another node offers.
class Client {
public:
    Client(Node& node, const std::string& name, const char* request_type, const char* response_type)
        : responses(node.reader("rr" + name + "Reply", response_type, SERVICE)),
          requests(node.writer("rq" + name + "Request", request_type, SERVICE))
    {
    }

    bool is_there()
    {
        fast::PublicationMatchedStatus readers;
        fast::SubscriptionMatchedStatus writers;
        requests.get_publication_matched_status(readers);
        responses.get_subscription_matched_status(writers);
        return readers.current_count > 0 && writers.current_count > 0;
    }

    void call(cdr::Bytes request)
    {
        rtps::WriteParams params;
        params.related_sample_identity().writer_guid() = responses.guid();
        if (!requests.write(&request, params)) {
            throw std::runtime_error("a request is not sent");
        }
        sent = params.sample_identity().sequence_number();
    }

    /// The answer to the call.
    std::optional<Sample> response()
    {
        while (auto sample = take(responses)) {
            const auto& identity = sample->info.related_sample_identity;
            const bool is_own = identity.writer_guid() == responses.guid() || identity.writer_guid() == requests.guid();
            if (is_own && identity.sequence_number() == sent) {
                return sample;
            }
        }
        return std::nullopt;
    }

private:
    fast::DataReader& responses;
    fast::DataWriter& requests;
    rtps::SequenceNumber_t sent;
};
