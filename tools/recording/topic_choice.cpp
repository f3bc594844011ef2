#include "tools/recording/topic_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <stdexcept>

namespace palp {

const TopicRow* find_topic(const std::string& name) {
  for (const TopicRow& row : kTopics)
    if (name == row.name || "palp/" + name == row.name) return &row;
  return nullptr;
}

namespace {

const TopicRow* known_topic(const std::string& name) {
  if (const TopicRow* row = find_topic(name)) return row;
  std::string all;
  for (const TopicRow& row : kTopics) all += fmt::format("{}{}", all.empty() ? "" : ", ", row.name);
  throw std::invalid_argument(fmt::format("there is no topic '{}'; there are {}", name, all));
}

}  // namespace

std::vector<const TopicRow*> choose_topics(const std::vector<std::string>& names) {
  std::vector<const TopicRow*> out;
  for (const std::string& name : names) out.push_back(known_topic(name));
  if (names.empty())
    for (const TopicRow& row : kTopics) out.push_back(&row);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::map<const TopicRow*, unsigned> parse_decimation(const std::vector<std::string>& texts) {
  std::map<const TopicRow*, unsigned> out;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    unsigned n = 0;
    if (equals != std::string::npos) {
      const char* end = text.data() + text.size();
      const auto [rest, error] = std::from_chars(text.data() + equals + 1, end, n);
      if (error != std::errc() || rest != end) n = 0;
    }
    if (n == 0) throw std::invalid_argument(fmt::format("'{}': TOPIC=N with N of 1 or more was expected", text));
    out[known_topic(text.substr(0, equals))] = n;
  }
  return out;
}

}  // namespace palp
