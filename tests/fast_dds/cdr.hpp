// Messages as CDR, the encoding of ROS 2: fields of structs in their order, checked against the bytes that are there.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/exceptions/NotEnoughMemoryException.h>
#include <fastdds/dds/topic/TopicDataType.hpp>

namespace cdr {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

/// A message as it is sent, its encapsulation of four bytes included.
using Bytes = std::vector<char>;

template <class T> struct is_list : std::false_type {};
template <class T> struct is_list<std::vector<T>> : std::true_type {};
template <class T> struct is_array : std::false_type {};
template <class T, size_t N> struct is_array<std::array<T, N>> : std::true_type {};

template <class T> constexpr bool is_simple = std::is_arithmetic_v<T> || std::is_same_v<T, std::string>;

/// Reads fields; a message that is too short, or says more than it holds, throws an exception of fastcdr.
class Decoder {
public:
    explicit Decoder(Bytes& bytes)
        : n_bytes(bytes.size()), buffer(bytes.data(), bytes.size()), source(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR)
    {
        source.read_encapsulation();
    }

    template <class... T> void operator()(T&... fields) { (one(fields), ...); }

private:
    size_t n_bytes;
    FastBuffer buffer;
    Cdr source;

    template <class T> void one(T& field)
    {
        if constexpr (is_simple<T>) {
            source.deserialize(field);
        } else if constexpr (is_list<T>::value) {
            uint32_t count;
            source.deserialize(count);
            // Every element has a byte at least.
            if (count > n_bytes - source.getSerializedDataLength()) {
                throw eprosima::fastcdr::exception::NotEnoughMemoryException("a list is longer than its message");
            }
            field.resize(count);
            elements(field);
        } else if constexpr (is_array<T>::value) {
            elements(field);
        } else {
            field.fields(*this);
        }
    }

    template <class T> void elements(T& list)
    {
        if constexpr (std::is_arithmetic_v<typename T::value_type>) {
            source.deserializeArray(list.data(), list.size());
        } else {
            for (auto& element : list) {
                one(element);
            }
        }
    }
};

/// Writes fields.
class Encoder {
public:
    Encoder() : sink(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR) { sink.serialize_encapsulation(); }

    template <class... T> void operator()(T&... fields) { (one(fields), ...); }

    Bytes bytes() const { return Bytes(buffer.getBuffer(), buffer.getBuffer() + sink.getSerializedDataLength()); }

private:
    FastBuffer buffer;
    Cdr sink;

    template <class T> void one(T& field)
    {
        if constexpr (is_simple<T>) {
            sink.serialize(field);
        } else if constexpr (is_list<T>::value) {
            sink.serialize(static_cast<uint32_t>(field.size()));
            elements(field);
        } else if constexpr (is_array<T>::value) {
            elements(field);
        } else {
            field.fields(*this);
        }
    }

    template <class T> void elements(T& list)
    {
        if constexpr (std::is_arithmetic_v<typename T::value_type>) {
            sink.serializeArray(list.data(), list.size());
        } else {
            for (auto& element : list) {
                one(element);
            }
        }
    }
};

template <class M> M decode(Bytes& bytes)
{
    M message{};
    Decoder decoder(bytes);
    message.fields(decoder);
    return message;
}

template <class M> Bytes encode(M message)
{
    Encoder encoder;
    message.fields(encoder);
    return encoder.bytes();
}

/// A type of DDS whose samples are [`Bytes`], with the name that ROS 2 gives it.
class Type final : public eprosima::fastdds::dds::TopicDataType {
public:
    explicit Type(const std::string& name)
    {
        setName(name.c_str());
        // As rmw_fastrtps: what an encapsulation takes; memory grows with the messages.
        m_typeSize = 4;
        m_isGetKeyDefined = false;
        auto_fill_type_object(false);
        auto_fill_type_information(false);
    }

    using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

    bool serialize(void* data, Payload* payload) override
    {
        const auto& bytes = *static_cast<Bytes*>(data);
        if (bytes.size() > payload->max_size) {
            return false;
        }
        std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(payload->data));
        payload->length = static_cast<uint32_t>(bytes.size());
        payload->encapsulation = CDR_LE;
        return true;
    }

    bool deserialize(Payload* payload, void* data) override
    {
        const auto* bytes = reinterpret_cast<char*>(payload->data);
        static_cast<Bytes*>(data)->assign(bytes, bytes + payload->length);
        return true;
    }

    std::function<uint32_t()> getSerializedSizeProvider(void* data) override
    {
        return [data] { return static_cast<uint32_t>(static_cast<Bytes*>(data)->size()); };
    }

    void* createData() override { return new Bytes(); }
    void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
    bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

} // namespace cdr
