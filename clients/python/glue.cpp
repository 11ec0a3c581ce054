// SPDX-License-Identifier: Apache-2.0
// The extension module of the Python package: rings, recordings, the control socket and giving, as
// bytes and numbers. The package beside it makes NumPy arrays of them.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/library/client.h"
#include "clients/library/drawer.h"
#include "clients/library/giver.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/sessions.h"
#include "proto/log/trace.h"
#include "proto/wire/schema.h"

namespace haptic {
namespace {

namespace py = pybind11;
using Unlocked = py::gil_scoped_release;
using ByteArray = py::array_t<uint8_t, py::array::c_style>;

constexpr int64_t kLookNs = 250'000;          // between two looks at a ring
constexpr int64_t kPatienceNs = 500'000'000;  // until the first segment comes

/// Memory and threads of a connection belong to the process that made it.
struct Connected {
  const pid_t pid = getpid();
  void check() const {
    if (pid != getpid()) throw MessageError("a connection does not survive fork(); make a new one");
  }
};
/// In a child by fork() there is no thread to be joined: what was the parent's is left alone.
struct LeftByChild {
  template <typename T>
  void operator()(T* held) const {
    if (held->pid == getpid()) delete held;
  }
};

/// The lists of some records, as far as they are in use.
class Lists {
 public:
  explicit Lists(std::span<const RecordPart> parts) : parts_(parts.begin(), parts.end()) {}

  void add(const std::byte* record) {
    for (const RecordPart& part : parts_) {
      uint32_t n;
      std::memcpy(&n, record + part.offset, sizeof n);
      const size_t length = std::min<size_t>(n, part.most) * part.element;
      const auto* begin = reinterpret_cast<const uint8_t*>(record + part.offset + kPartHeader);
      places_.emplace_back(bytes_.size(), length);
      bytes_.insert(bytes_.end(), begin, begin + length);
    }
  }
  ByteArray values(size_t record, size_t part) const {
    const auto [begin, length] = places_.at(record * parts_.size() + part);
    return ByteArray(static_cast<py::ssize_t>(length), bytes_.data() + begin);
  }

 private:
  std::vector<RecordPart> parts_;
  std::vector<std::pair<size_t, size_t>> places_;  // begin and length, record by record
  std::vector<uint8_t> bytes_;
};

/// Bytes of a record before its lists.
constexpr size_t fixed_bytes(size_t size, std::span<const RecordPart> parts) {
  return parts.empty() ? size : parts[0].offset;
}

/// Of who is not connected any more: why it was refused, "ended" (as told) or "lost".
std::string why_gone(const std::string& refusal, bool has_ended) {
  return !refusal.empty() ? refusal : has_ended ? "ended" : "lost";
}

/// A ring of a session. Any thread may use it that does not hold the GIL.
class Reader : public Connected {
 public:
  Reader(const std::string& session, size_t fixed, std::span<const RecordPart> parts)
      : fixed_(fixed),
        attachments_(connect_session(session), {.on_closed = [this] { gone_ns_ = now_ns(); }}),
        parts_(parts),
        control_(attachments_.source<ControlChannels>()) {}
  virtual ~Reader() = default;

  /// Number of records read and lost, and the lists of what was read.
  py::tuple read(ByteArray out, bool newest) {
    check();
    auto* bytes = reinterpret_cast<std::byte*>(out.mutable_data());
    const size_t most = static_cast<size_t>(out.nbytes()) / fixed_;
    auto lists = std::make_unique<Lists>(parts_);
    size_t n = 0;
    uint64_t n_lost = 0;
    {
      const Unlocked unlocked;
      const std::lock_guard lock(mutex_);
      n = take(bytes, most, newest, *lists);
      n_lost = lost() - std::exchange(lost_before_, lost());
    }
    return py::make_tuple(n, n_lost, py::cast(std::move(lists)));
  }
  bool wait(double seconds) {
    check();
    const Unlocked unlocked;
    for (const int64_t end_ns = now_ns() + static_cast<int64_t>(seconds * 1e9);;) {
      if (const std::lock_guard lock(mutex_); has_more()) return true;
      const int64_t t_ns = now_ns();
      if (t_ns >= end_ns) return false;
      sleep_until(std::min(end_ns, t_ns + kLookNs));
    }
  }
  int64_t gone_ns() const { return gone_ns_; }
  std::string gone() {
    check();
    if (attachments_.is_connected()) return "";
    control_.channels();
    return why_gone(attachments_.refusal(), has_ended(control_.header()));
  }

 protected:
  virtual bool has_more() = 0;
  virtual size_t take(std::byte* out, size_t most, bool newest, Lists& lists) = 0;
  virtual uint64_t lost() const = 0;

  std::atomic<int64_t> gone_ns_{0};  // since when there is no hapticd
  const size_t fixed_;               // bytes of a record before its lists
  Attachments attachments_;

 private:
  const std::span<const RecordPart> parts_;
  Source<ControlChannels> control_;
  std::mutex mutex_;
  uint64_t lost_before_ = 0;
};

template <auto kMember>
class ReaderOf : public Reader {
  using Item = typename RingSource<kMember>::Item;

 public:
  ReaderOf(const std::string& session, uint32_t hand, Start start)
      : Reader(session, fixed_bytes(sizeof(Item), kParts<Item>), kParts<Item>),
        ring_(attachments_.ring<kMember>(start, hand)) {
    attachments_.start();
    // a ring counts from where it is found
    for (const int64_t end_ns = now_ns() + kPatienceNs; now_ns() < end_ns;) {
      if (has_more() || ring_.header() != nullptr || !attachments_.is_connected()) break;
      sleep_until(now_ns() + kLookNs);
    }
  }

 private:
  bool has_more() override { return is_waiting_ = is_waiting_ || ring_.next(*item_); }
  size_t take(std::byte* out, size_t most, bool newest, Lists& lists) override {
    size_t n = 0;
    while (n < most && has_more()) {
      if (newest) ring_.latest(*item_);
      is_waiting_ = false;
      const auto* record = reinterpret_cast<const std::byte*>(item_.get());
      std::memcpy(out + fixed_ * n++, record, fixed_);
      lists.add(record);
      if (newest) break;
    }
    return n;
  }
  uint64_t lost() const override { return ring_.lost(); }

  RingSource<kMember> ring_;
  std::unique_ptr<Item> item_ = std::make_unique<Item>();
  bool is_waiting_ = false;  // item_ was read and not passed on
};

Reader* open_reader(const std::string& session, const std::string& name, uint32_t hand,
                    bool oldest) {
  if (hand >= kMostHands) throw MessageError("hands are 0 to " + std::to_string(kMostHands - 1));
  const Unlocked unlocked;
  const Start start = oldest ? Start::kOldest : Start::kNewest;
  if (name == "servo") return new ReaderOf<&ServoChannels::frames>(session, hand, start);
  if (name == "contact") return new ReaderOf<&ContactChannels::sets>(session, hand, start);
  if (name == "sim") return new ReaderOf<&SimChannels::frames>(session, kFirstHand, start);
  return new ReaderOf<&ControlChannels::frames>(session, kFirstHand, start);
}

class Log {
 public:
  explicit Log(const std::string& path) : trace_(path) {}

  std::vector<std::pair<py::bytes, std::string>> topics() const {
    std::vector<std::pair<py::bytes, std::string>> out;
    for (const TopicInfo& topic : trace_.topics()) {
      out.emplace_back(topic.name, topic.schema.substr(topic.schema.rfind('/') + 1));
    }
    return out;
  }
  std::string notice(const std::string& topic) const { return trace_.notice(find(topic)); }
  py::bytes metadata(const std::string& record, const std::string& key) const {
    return trace_.mcap().metadata(record, key);
  }
  bool finished() const { return trace_.mcap().finished(); }

  /// Fixed parts, instants (monotonic, real time) and lists of the records between two instants.
  py::tuple read(const std::string& name, int64_t from_ns, int64_t to_ns) {
    const TopicInfo topic = find(name);
    const size_t fixed = fixed_bytes(topic.size, topic.parts);
    std::vector<uint8_t> bytes;
    std::vector<int64_t> stamps;
    auto lists = std::make_unique<Lists>(topic.parts);
    {
      const Unlocked unlocked;
      const std::lock_guard lock(mutex_);
      TopicCursor cursor(trace_, topic);
      if (from_ns > std::numeric_limits<int64_t>::min()) cursor.seek(from_ns - 1);
      while (cursor.next() && cursor.stamp().t_ns <= to_ns) {
        const std::byte* record = cursor.bytes();
        const auto* begin = reinterpret_cast<const uint8_t*>(record);
        bytes.insert(bytes.end(), begin, begin + fixed);
        stamps.push_back(cursor.stamp().t_ns);
        stamps.push_back(cursor.stamp().realtime_ns);
        lists->add(record);
      }
    }
    return py::make_tuple(ByteArray(std::ssize(bytes), bytes.data()),
                          py::array_t<int64_t>(std::ssize(stamps), stamps.data()),
                          py::cast(std::move(lists)));
  }

 private:
  TopicInfo find(const std::string& name) const {
    for (const TopicInfo& topic : trace_.topics()) {
      if (topic.name == name) return topic;
    }
    throw MessageError("there is no topic '" + shown(name) + "'; there are " +
                       joined(trace_.topics(), &TopicInfo::name));
  }

  TraceReader trace_;
  std::mutex mutex_;
};

/// The records that an array holds.
template <typename T>
std::span<const T> records_in(const ByteArray& bytes) {
  const auto size = static_cast<size_t>(bytes.nbytes());
  if (size % sizeof(T) != 0) throw py::value_error("not the bytes of such records");
  return {reinterpret_cast<const T*>(bytes.data()), size / sizeof(T)};
}

struct Giving : Connected {
  Giving(const std::string& session, const std::string& name)
      : client(session), giver(client, session, name) {
    client.start();
  }
  Giver& checked() { return check(), giver; }
  uint32_t object(const std::string& name) { return checked().object(name); }
  py::array_t<double> pushed(uint32_t object) {
    const GivenPush push = checked().pushed(object);
    return py::array_t<double>(13, reinterpret_cast<const double*>(&push));
  }
  template <typename T, auto kSay>
  void say(const ByteArray& bytes) {
    for (const T& one : records_in<T>(bytes)) (checked().*kSay)(one);
  }
  void publish() { checked().publish(); }
  bool draw(const ByteArray& points, const ByteArray& lines) {
    if (!drawer) drawer.emplace(checked().seat());
    return drawer->draw(records_in<DrawnPoint>(points), records_in<DrawnLine>(lines));
  }
  std::string gone() {
    check();
    return client.is_connected() ? "" : why_gone(client.refusal(), client.has_ended());
  }

  Client client;
  Giver giver;
  std::optional<Drawer> drawer;
};
static_assert(sizeof(GivenPush) == 13 * sizeof(double));

/// By name: size, doc and fields of each record.
py::dict records() {
  py::dict out;
  for (const RecordRow& record : all_records()) {
    py::list fields;
    for (const RecordField& field : record.fields) {
      fields.append(py::make_tuple(field.name, field.type, field.count, field.offset, field.size,
                                   field.is_part, field.doc));
    }
    out[py::str(std::string(record.name))] = py::make_tuple(record.size, record.doc, fields);
  }
  return out;
}

std::string say(const std::string& session, const std::string& line, double patience) {
  const std::string answer = say_to_session(session, line, static_cast<int64_t>(patience * 1e9));
  if (const std::optional<std::string> why = refusal_in(answer)) throw MessageError(*why);
  return answer;
}

}  // namespace
}  // namespace haptic

PYBIND11_MODULE(_hapticd, m) {
  using namespace haptic;
  using py::arg;
  const py::call_guard<Unlocked> unlocked;
  const py::metaclass plain(reinterpret_cast<PyObject*>(&PyType_Type));
  py::register_exception<MessageError>(m, "Error", PyExc_RuntimeError);
  m.attr("abi") = kAbiMajor;
  m.def("records", &records);
  m.def("say", &say, arg("session"), arg("line"), arg("patience"), unlocked);
  m.def("find", &find_session, arg("session"), unlocked);
  py::class_<Lists>(m, "Lists", plain).def("values", &Lists::values, arg("record"), arg("part"));
  py::class_<Reader, std::unique_ptr<Reader, LeftByChild>>(m, "Reader", plain)
      .def(py::init(&open_reader), arg("session"), arg("name"), arg("hand"), arg("oldest"))
      .def("read", &Reader::read, arg("out").noconvert(), arg("newest"))
      .def("wait", &Reader::wait, arg("seconds"))
      .def("gone", &Reader::gone)
      .def("gone_ns", &Reader::gone_ns);
  py::class_<Log>(m, "Log", plain)
      .def(py::init<const std::string&>(), arg("path"), unlocked)
      .def("topics", &Log::topics)
      .def("notice", &Log::notice, arg("topic"))
      .def("metadata", &Log::metadata, arg("record"), arg("key"))
      .def("finished", &Log::finished)
      .def("read", &Log::read, arg("topic"), arg("from_ns"), arg("to_ns"));
  py::class_<Giving, std::unique_ptr<Giving, LeftByChild>>(m, "Giving", plain)
      .def(py::init<const std::string&, const std::string&>(), arg("session"), arg("name"),
           unlocked)
      .def("object", &Giving::object, arg("name"))
      .def("pushed", &Giving::pushed, arg("object"))
      .def("move", &Giving::say<GivenMotion, &Giver::move>, arg("motions").noconvert())
      .def("push", &Giving::say<GivenWrench, &Giver::push>, arg("pushes").noconvert())
      .def("touch", &Giving::say<GivenPlane, &Giver::touch>, arg("planes").noconvert())
      .def("publish", &Giving::publish)
      .def("draw", &Giving::draw, arg("points").noconvert(), arg("lines").noconvert())
      .def("gone", &Giving::gone);
}
