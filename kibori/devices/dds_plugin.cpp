// SPDX-License-Identifier: MIT
// Implements dds_plugin.h (kibori_dds.so) with Fast DDS.
#include <kibori/devices/dds_plugin.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;

constexpr uint32_t kLongest = 512;  // maximum size of a message [bytes], including its frame's name
constexpr int kDepth = 1000;        // one second of messages for a late reader

// std_msgs/Header, then doubles: position and orientation, or force and torque. The two messages
// differ only in the number of doubles.
template <size_t N>
struct Stamped {
  int32_t sec = 0;
  uint32_t nanosec = 0;
  std::string frame;
  double values[N] = {};
};

template <size_t N>
class StampedType : public dds::TopicDataType {
 public:
  explicit StampedType(const char* name) {
    setName(name);
    m_typeSize = kLongest;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const auto& message = *static_cast<const Stamped<N>*>(data);
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    payload->encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
    try {
      cdr.serialize_encapsulation();
      cdr << message.sec << message.nanosec << message.frame;
      for (const double value : message.values) cdr << value;
    } catch (const std::exception&) {
      return false;
    }
    payload->length = static_cast<uint32_t>(cdr.getSerializedDataLength());
    return true;
  }
  // Another program may send anything. Fast CDR checks the length of the data and throws if it is
  // too short.
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    auto& message = *static_cast<Stamped<N>*>(data);
    eprosima::fastcdr::FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    try {
      cdr.read_encapsulation();
      cdr >> message.sec >> message.nanosec >> message.frame;
      for (double& value : message.values) cdr >> value;
    } catch (const std::exception&) {
      return false;
    }
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void*) override {
    return [] { return kLongest; };
  }
  void* createData() override { return new Stamped<N>; }
  void deleteData(void* data) override { delete static_cast<Stamped<N>*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};
using Pose = Stamped<7>;
using Wrench = Stamped<6>;

struct Link final : dds::DataReaderListener {
  dds::DomainParticipant* participant = nullptr;
  std::vector<dds::DataWriter*> poses, wrenches;
  kibori_dds_on_pose on_pose = nullptr;
  void* user = nullptr;

  Link() = default;
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  ~Link() override {
    if (!participant) return;
    participant->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant);
  }

  void on_data_available(dds::DataReader* reader) override {
    Pose pose;
    dds::SampleInfo info;
    while (reader->take_next_sample(&pose, &info) == ReturnCode_t::RETCODE_OK)
      if (info.valid_data)
        on_pose(user, pose.sec * int64_t{1000000000} + pose.nanosec, pose.values);
  }
};

// The DDS name of a ROS 2 topic.
std::string ros_topic(const char* name) { return std::string("rt") + name; }

template <size_t N>
bool write(dds::DataWriter* writer, int64_t ns, const char* frame, const double* values) {
  Stamped<N> message;
  message.sec = static_cast<int32_t>(ns / 1000000000);
  message.nanosec = static_cast<uint32_t>(ns % 1000000000);
  message.frame.assign(frame, strnlen(frame, 64));
  std::memcpy(message.values, values, sizeof message.values);
  return writer->write(&message);
}

void* open_link(uint32_t domain, const char* const* poses, int pose_count,
                const char* const* wrenches, int wrench_count, const char* reads,
                kibori_dds_on_pose on_pose, void* user, char* error, int error_room) {
  const auto no = [&](const char* why) -> void* {
    std::snprintf(error, static_cast<size_t>(error_room), "%s", why);
    return nullptr;
  };
  try {
    // Standard output belongs to the program, so errors go to stderr.
    dds::Log::ClearConsumers();
    dds::Log::SetVerbosity(dds::Log::Kind::Error);
    auto errors = std::make_unique<dds::StdoutErrConsumer>();
    errors->stderr_threshold(dds::Log::Kind::Error);
    dds::Log::RegisterConsumer(std::move(errors));
    auto link = std::make_unique<Link>();
    link->on_pose = on_pose;
    link->user = user;
    dds::DomainParticipantQos qos;
    qos.name("kibori");
    link->participant =
        dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    if (!link->participant) return no("Fast DDS cannot join the domain");
    dds::TypeSupport pose_type(new StampedType<7>("geometry_msgs::msg::dds_::PoseStamped_")),
        wrench_type(new StampedType<6>("geometry_msgs::msg::dds_::WrenchStamped_"));
    pose_type.register_type(link->participant);
    wrench_type.register_type(link->participant);
    dds::Publisher* const publisher =
        link->participant->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    if (!publisher) return no("Fast DDS could not create a publisher");
    // Reliable, as ROS 2's readers request by default. A late reader gets one second of messages.
    dds::DataWriterQos writes;
    writes.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
    writes.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    writes.history().depth = kDepth;
    const auto add = [&](const char* name, const dds::TypeSupport& type,
                         std::vector<dds::DataWriter*>& to) {
      dds::Topic* const topic = link->participant->create_topic(
          ros_topic(name), type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
      dds::DataWriter* const writer = topic ? publisher->create_datawriter(topic, writes) : nullptr;
      to.push_back(writer);
      return writer != nullptr;
    };
    for (int i = 0; i < pose_count; i++)
      if (!add(poses[i], pose_type, link->poses)) return no("Fast DDS could not create a writer");
    for (int i = 0; i < wrench_count; i++)
      if (!add(wrenches[i], wrench_type, link->wrenches))
        return no("Fast DDS could not create a writer");
    if (reads) {
      dds::Subscriber* const subscriber =
          link->participant->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
      dds::Topic* const topic = link->participant->create_topic(
          ros_topic(reads), pose_type.get_type_name(), dds::TOPIC_QOS_DEFAULT);
      // Keeps only the newest pose. A best-effort reader accepts reliable and best-effort writers.
      dds::DataReaderQos newest;
      newest.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
      newest.history().kind = dds::KEEP_LAST_HISTORY_QOS;
      newest.history().depth = 1;
      if (!subscriber || !topic || !subscriber->create_datareader(topic, newest, link.get()))
        return no("Fast DDS could not create a reader");
    }
    return link.release();
  } catch (const std::exception& failed) {
    return no(failed.what());
  }
}

void close_link(void* link) { delete static_cast<Link*>(link); }

int write_pose(void* link, int topic, int64_t ns, const char* frame, const double pose[7]) {
  return write<7>(static_cast<Link*>(link)->poses[static_cast<size_t>(topic)], ns, frame, pose);
}

int write_wrench(void* link, int topic, int64_t ns, const char* frame, const double wrench[6]) {
  return write<6>(static_cast<Link*>(link)->wrenches[static_cast<size_t>(topic)], ns, frame,
                  wrench);
}

}  // namespace

extern "C" __attribute__((visibility("default")))
const kibori_dds kibori_dds_1 = {open_link, close_link, write_pose, write_wrench};
