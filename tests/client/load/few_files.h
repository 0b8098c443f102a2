#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <vector>

namespace rivage::client::load {

/// As long as it lives, this process can open only so many files more.
class FewFiles {
public:
    explicit FewFiles(int left) {
        getrlimit(RLIMIT_NOFILE, &before_);
        rlimit low = before_;
        low.rlim_cur = 256;
        setrlimit(RLIMIT_NOFILE, &low);
        for (int fd = dup(STDERR_FILENO); fd >= 0; fd = dup(STDERR_FILENO)) taken_.push_back(fd);
        for (; left > 0 && !taken_.empty(); --left) {
            close(taken_.back());
            taken_.pop_back();
        }
    }
    ~FewFiles() {
        for (const int fd : taken_) close(fd);
        setrlimit(RLIMIT_NOFILE, &before_);
    }
    FewFiles(const FewFiles&) = delete;
    FewFiles& operator=(const FewFiles&) = delete;

private:
    rlimit before_{};
    std::vector<int> taken_;
};

}  // namespace rivage::client::load
