// SPDX-License-Identifier: GPL-3.0-or-later
// A field that one line of proto/wire/records.def has added to ControlFrame: the struct has it, its
// text and the table of records too, and a recording of the layout before is read with its default.
// Argument: that recording. Says what is wrong, and exits with 1.
#include <algorithm>
#include <cstdio>
#include <sstream>
#include <string>

#include "proto/log/csv.h"
#include "proto/log/trace.h"
#include "proto/wire/schema.h"

namespace {

using namespace haptic;

constexpr double kDefault = 7;  // in the line

int n_wrong = 0;

void check(bool holds, const char* what) {
  if (holds) return;
  std::printf("wrong: %s\n", what);
  ++n_wrong;
}

}  // namespace

int main(int, char** argv) {
  const TraceReader log(argv[1]);
  const std::vector<ControlFrame> frames = log.read(kControlTopic);
  check(!frames.empty(), "the recording has no ControlFrame");
  check(std::ranges::all_of(frames, [](const auto& f) { return f.from_outside == kDefault; }),
        "a record of the layout before has not the default");
  const TopicInfo topic = info_of(kControlTopic);
  const std::string notice = log.notice(topic);
  check(notice.ends_with("from_outside (7: nothing was)"), notice.c_str());
  const Fields fields = flatten(topic.text);
  const auto field = std::ranges::find(fields, "from_outside", &Field::name);
  check(field != fields.end() && field->unit == "m" &&
            field->offset == offsetof(ControlFrame, from_outside),
        "the text of the record has it not in its place");
  std::ostringstream csv;
  export_csv(log, topic, csv);
  check(csv.str().find(",from_outside_m\n") != std::string::npos, "an export has no column for it");
  const RecordRow* record = find_record("ControlFrame");
  check(record->fields.back().name == "from_outside", "the table of records has it not");
  std::printf("a field is one line: %s\n", n_wrong == 0 ? "yes" : "no");
  return n_wrong == 0 ? 0 : 1;
}
