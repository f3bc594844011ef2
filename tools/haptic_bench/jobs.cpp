#include "tools/haptic_bench/jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "config/json_file.h"

namespace palp::bench {

std::vector<Row> work_off(const std::vector<Job>& jobs, unsigned threads) {
  setenv("OMP_NUM_THREADS", "1", 1);  // jobs run side by side instead
  std::vector<std::vector<Row>> rows(jobs.size());
  std::atomic<std::size_t> next{0};
  std::mutex talk;
  std::size_t done = 0;
  std::exception_ptr failure;
  const auto serve = [&] {
    for (std::size_t k; (k = next++) < jobs.size();) {
      const auto begin = std::chrono::steady_clock::now();
      try {
        rows[k] = jobs[k].work();
        for (Row& r : rows[k]) r.job = jobs[k].number;
      } catch (...) {
        const std::lock_guard lock(talk);
        failure = std::current_exception();
        next = jobs.size();
        return;
      }
      const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const std::lock_guard lock(talk);
      fmt::print(stderr, "{}/{} {} ({:.1f} s)\n", ++done, jobs.size(), jobs[k].what, took);
      for (const Row& r : rows[k])
        fmt::print(stderr, "    {}: {:.3g} {}{} {}\n", r.metric, r.result, r.unit,
                   r.pass ? (*r.pass ? ", pass" : ", FAIL") : "", r.note);
    }
  };
  std::vector<std::thread> pool;
  for (unsigned k = 0; k < threads; ++k) pool.emplace_back(serve);
  for (std::thread& t : pool) t.join();
  if (failure) std::rethrow_exception(failure);
  std::vector<Row> all;
  for (std::vector<Row>& r : rows) all.insert(all.end(), r.begin(), r.end());
  return all;
}

std::vector<Job> part_of(std::vector<Job> jobs, const std::string& part) {
  if (part.empty()) return jobs;
  for (std::size_t k = 0; k < jobs.size(); ++k) jobs[k].number = k + 1;
  std::size_t k = 0, n = 0;
  char end = 0;
  if (std::sscanf(part.c_str(), "%zu/%zu%c", &k, &n, &end) != 2 || k < 1 || k > n)
    throw std::invalid_argument("the part '" + part + "' is not of the form 2/5, from 1/5 to 5/5");
  std::vector<Job> some;
  for (std::size_t i = k - 1; i < jobs.size(); i += n) some.push_back(jobs[i]);
  return some;
}

std::vector<Row> merged(const std::vector<std::string>& files, std::string& commands) {
  std::vector<Row> all;
  for (const std::string& file : files) {
    std::ifstream in(file);
    if (!in) throw std::invalid_argument("cannot read '" + file + "': give JSON files that --json has written");
    try {
      const Json part = Json::parse(in);
      commands += (commands.empty() ? "" : "`, `") + part.at("command").get<std::string>();
      for (Row& r : rows_from(part.at("rows"))) all.push_back(std::move(r));
    } catch (const Json::exception& error) {
      throw std::invalid_argument(fmt::format("{}: {}; give JSON files that --json has written", file, error.what()));
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Row& x, const Row& y) { return x.job < y.job; });
  return all;
}

}  // namespace palp::bench
