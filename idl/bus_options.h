// The command-line options of the bus, the same for every executable. Header only: the bus itself does not need CLI11.
#pragma once

#include <CLI/CLI.hpp>

#include <map>
#include <string>

#include "idl/bus.h"

namespace palp {

// Adds --dds, --domain, --network, --interface and --peer to app; they are stored in options, which must outlive the
// parsing. Values out of range are refused by CLI11 with one sentence.
inline void add_bus_options(CLI::App& app, BusOptions& options) {
  const std::map<std::string, Vendor> vendors{{"cyclone", Vendor::cyclone}, {"fastdds", Vendor::fastdds}};
  app.add_option("--dds", options.vendor, "DDS vendor: cyclone or fastdds")
      ->transform(CLI::CheckedTransformer(vendors, CLI::ignore_case).description(""))
      ->type_name("VENDOR")
      ->default_str(to_string(options.vendor))
      ->group("Bus");
  app.add_option("--domain", options.domain, "DDS domain; processes in different domains do not see each other")
      ->check(CLI::Range(0, kMaxDomain))
      ->capture_default_str()
      ->group("Bus");
  app.add_flag("--network", options.network,
               "leave the loopback interface and find peers by multicast; give it to every process of a run")
      ->group("Bus");
  app.add_option("--interface", options.interface,
                 "network interface to use: its name or address (with --network or --peer)")
      ->type_name("NAME")
      ->group("Bus");
  app.add_option("--peer", options.peers, "address of another host (repeatable); implies --network")
      ->type_name("ADDRESS")
      ->group("Bus");
}

}  // namespace palp
