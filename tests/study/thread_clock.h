#pragma once

#include <ctime>

namespace rivage::study {

/// Milliseconds of this thread since it was made: other work on the machine does not count.
class ThreadClock {
public:
    [[nodiscard]] double milliseconds() const { return now() - started_; }

private:
    static double now() {
        timespec time{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
    }
    double started_ = now();
};

}  // namespace rivage::study
