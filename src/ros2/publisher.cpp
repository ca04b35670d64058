// SPDX-License-Identifier: Apache-2.0
// The queue of a topic, and the thread that empties it.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "base/maker_process.hpp"
#include "base/os.hpp"
#include "base/threads.hpp"
#include "gnosphere/error.hpp"
#include "ros2/check.hpp"
#include "ros2/discovery.hpp"
#include "ros2/wire.hpp"

namespace gnosphere::ros2 {
namespace {

constexpr uint32_t kLastDomain = 232;  // beyond it the ports of DDS end

[[noreturn]] void refusePublisher(const std::string& why) {
  throw Error(ErrorCode::invalidArgument, "ros2::Publisher: " + why);
}

/// Refuses a process that was forked from the one that publishes.
void checkMaker(const MakerProcess& publishing) {
  if (!publishing.isParent()) return;
  refusePublisher(
      "the process was forked from one that publishes, whose threads it does not have; start it anew, in "
      "Python with 'spawn'");
}

/// Returns the process that has made the first publisher.
const MakerProcess& publishingProcess() {
  static const MakerProcess kFirst;
  return kFirst;
}

uint32_t domainFromEnvironment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (!text || !*text) return 0;
  uint32_t domain = 0;
  const char* const end = text + std::strlen(text);
  const auto [rest, failed] = std::from_chars(text, end, domain);
  if (failed != std::errc() || rest != end || domain > kLastDomain)
    refusePublisher("ROS_DOMAIN_ID is '" + std::string(text) + "', which is none of 0 to " +
                    std::to_string(kLastDomain));
  return domain;
}

/// The name that a topic of ROS has on the wire.
std::string wireName(const std::string& topic) {
  const auto invalid = [&] {
    refusePublisher(
        "'" + topic +
        "' is no name of a topic: it has parts of letters, digits and underscores between slashes, and no part "
        "begins with a digit");
  };
  char before = '/';
  for (size_t i = topic.starts_with('/') ? 1 : 0; i < topic.size(); before = topic[i++]) {
    const auto c = static_cast<unsigned char>(topic[i]);
    const bool begins = before == '/';
    if (c == '/' ? begins : begins ? !std::isalpha(c) && c != '_' : !std::isalnum(c) && c != '_') invalid();
  }
  if (before == '/') invalid();
  return (topic.starts_with('/') ? "rt" : "rt/") + topic;
}

Topic topicOf(MessageType type, const std::string& name, const PublisherOptions& options) {
  if (static_cast<size_t>(type) >= std::variant_size_v<Message>) refusePublisher("there is no such type of message");
  if (options.qos.depth == 0) refusePublisher("the depth of the queue is 0; it must be 1 at least");
  Topic topic;
  topic.type = type;
  topic.name = wireName(name);
  topic.qos = options.qos;
  topic.domain = options.domain ? *options.domain : domainFromEnvironment();
  checkMaker(publishingProcess());
  if (topic.domain > kLastDomain)
    refusePublisher("the domain is " + std::to_string(topic.domain) + "; the last one is " +
                    std::to_string(kLastDomain));
  topic.discovery = discoveryConfiguration(discoveryVariables(), options.localhostOnly, os::processNumber());
  return topic;
}

/// Returns the queue of a publisher, unless it was moved elsewhere.
template <class Queue>
Queue& queueOf(const std::unique_ptr<Queue>& queue) {
  if (!queue) refusePublisher("this one was moved to another variable; use that one");
  return *queue;
}

}  // namespace

class Publisher::Queue {
 public:
  explicit Queue(const Topic& topic)
      : type_(topic.type),
        depth_(topic.qos.depth),
        wire_(openWire(topic)),
        thread_(
            startThread("ros2::Publisher: the thread that sends the messages of " + topic.name, [this] { loop(); })) {}
  ~Queue() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  const MakerProcess& maker() const { return maker_; }

  void push(Message message) {
    checkMaker(maker_);
    if (message.index() != static_cast<size_t>(type_)) refusePublisher("the topic has messages of another type");
    check(message);
    Message replaced;  // destroyed after the lock is released
    {
      const std::lock_guard lock(mutex_);
      ++counts_.published;
      if (waiting_.size() == depth_) {
        replaced = std::move(waiting_.front());
        waiting_.pop_front();
        ++counts_.dropped;
      }
      waiting_.push_back(std::move(message));
    }
    changed_.notify_all();
  }

  bool flush(double seconds) {
    checkMaker(maker_);
    const std::chrono::duration<double> limit(std::min(std::max(0.0, seconds), 1e6));  // 0 if it is NaN
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, limit, [&] { return waiting_.empty() && !sending_; });
  }

  PublisherCounts counts() {
    checkMaker(maker_);
    const uint32_t subscribers = wire_->subscribers();
    const std::lock_guard lock(mutex_);
    PublisherCounts now = counts_;
    now.waiting = waiting_.size() + (sending_ ? 1 : 0);
    now.subscribers = subscribers;
    return now;
  }

 private:
  void loop() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [&] { return !waiting_.empty() || ended_; });
      if (ended_) return;
      const Message message = std::move(waiting_.front());
      waiting_.pop_front();
      sending_ = true;
      lock.unlock();
      const bool sent = write(message);
      lock.lock();
      sending_ = false;
      ++(sent ? counts_.sent : counts_.dropped);
      changed_.notify_all();
    }
  }

  // A message for which there is no memory is dropped; an exception would end the process.
  bool write(const Message& message) {
    try {
      return wire_->write(message);
    } catch (const std::exception&) {
      return false;
    }
  }

  const MakerProcess maker_;
  const MessageType type_;
  const size_t depth_;
  const std::unique_ptr<Wire> wire_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Message> waiting_;
  PublisherCounts counts_;
  bool sending_ = false, ended_ = false;
  std::jthread thread_;
};

Publisher::Publisher(MessageType type, const std::string& topic, const PublisherOptions& options)
    : queue_(std::make_unique<Queue>(topicOf(type, topic, options))) {}
// A forked process cannot end a thread that it does not have, nor tell subscribers that the topic is gone.
Publisher::~Publisher() {
  leaveToParent(queue_);
}
Publisher::Publisher(Publisher&&) noexcept = default;
Publisher& Publisher::operator=(Publisher&& other) noexcept {
  if (this == &other) return *this;
  const Publisher replaced(std::move(*this));
  queue_ = std::move(other.queue_);
  return *this;
}

void Publisher::publish(Message message) {
  queueOf(queue_).push(std::move(message));
}
bool Publisher::flush(double seconds) {
  return queueOf(queue_).flush(seconds);
}
PublisherCounts Publisher::counts() const {
  return queueOf(queue_).counts();
}

}  // namespace gnosphere::ros2
