#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/load/verdict.h"

namespace rivage::client::load {

struct SelftestPlan {
    bool brief = false;   ///< shorter, and what depends on a quiet machine is told but not judged
    bool wrk = true;      ///< compare with wrk, if it is installed
    double rate = 20000;  ///< requests a second that the generator is asked for
    std::vector<int> pins = {};  ///< the processor of the generator
};

/// One promise of the generator, and what came of it.
struct SelftestCheck {
    std::string name;
    std::string figures;
    bool kept = false;
    bool judged = true;  ///< false: the figures are for the reader only
};

/// Measures the generator itself, against a server of its own on loopback: whether a scripted
/// stall of 1 s shows in the corrected percentiles of an open loop and not in those of a closed
/// one; whether the histogram agrees with sorted values; whether sends are in time; how many it
/// can do; whether wrk finds the same.
std::vector<SelftestCheck> runSelftest(const SelftestPlan& plan, Interrupt& interrupt,
                                       const std::function<void(const SelftestCheck&)>& say);

/// The plan of a load of plain GETs on a server on loopback.
Outcome<LoadPlan> plainLoad(const std::string& url, const ArrivalPlan& arrivals, double seconds);

/// Requests a second in the output of wrk; 0 if there are none.
[[nodiscard]] double readWrk(const std::string& output);

}  // namespace rivage::client::load
