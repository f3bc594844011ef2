// The jobs of a table: each measures one metric in one cell, independently of all others.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/haptic_bench/results.h"

namespace palp::bench {

struct Job {
  std::size_t number = 0;  // in the whole table, from 1 on; 0: it is not done in parts
  std::string what;
  std::function<std::vector<Row>()> work;
};

// Runs the jobs on so many threads, each simulation on one thread, and says on stderr what each gave. Returns the rows
// in the order of the jobs, whoever ends first. Throws the last job's failure, after which no job is begun.
std::vector<Row> work_off(const std::vector<Job>& jobs, unsigned threads);

// Returns every n-th of the jobs from the k-th on, numbered as in the whole; part "k/n", or empty for all jobs as they
// are. The parts of one table take about equally long. Throws std::invalid_argument.
std::vector<Job> part_of(std::vector<Job> jobs, const std::string& part);

// Returns the rows that JSON files of several parts hold, in the order that the whole table would have; rows that
// belong to no part stay in the order of the files. Adds the commands that made them to `commands`. Throws
// std::invalid_argument where a file is not what --json writes.
std::vector<Row> merged(const std::vector<std::string>& files, std::string& commands);

}  // namespace palp::bench
