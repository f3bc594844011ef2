// The names of topics on the command lines of the recorder and the replayer.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "idl/topics.h"

namespace palp {

// Returns the rows of the topics that the user named, with or without "palp/", in the order of kTopics; all when none
// is named. Throws std::invalid_argument listing the topics that there are.
std::vector<const TopicRow*> choose_topics(const std::vector<std::string>& names);
// Returns the topic of that name; null when there is none.
const TopicRow* find_topic(const std::string& name);

// Reads "particles=4" and the like: keep every 4th. Throws std::invalid_argument with one sentence.
std::map<const TopicRow*, unsigned> parse_decimation(const std::vector<std::string>& texts);

}  // namespace palp
