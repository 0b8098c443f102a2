#pragma once

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <map>
#include <mutex>
#include <string>

#include "server/http/request_record.h"
#include "server/http/service.h"

namespace rivage::server {

/// What /metrics answers. Counts what requests and jobs report when they end, and reads the rest
/// when it is asked. No label has a value that a client chooses: routes are those of the table,
/// methods and problems those that are known. Safe to use from several threads.
class Metrics {
public:
    Metrics();

    void requestEnded(const RequestRecord& record);
    void jobEnded(const JobSnapshot& job);

    /// Prometheus text, version 0.0.4.
    [[nodiscard]] std::string text(const Service& service);

private:
    using Labels = prometheus::Labels;
    void gauge(const char* name, const char* help, double value, const Labels& labels = {});
    void count(const char* name, const char* help, double total, const Labels& labels = {});
    void readPool(const Service& service);
    void readConnections(const Service& service);
    void readProcess();

    prometheus::Registry registry_;
    prometheus::Family<prometheus::Histogram>& requestSeconds_;
    prometheus::Family<prometheus::Histogram>& requestBytes_;
    prometheus::Family<prometheus::Histogram>& responseBytes_;
    prometheus::Family<prometheus::Counter>& jobs_;
    prometheus::Family<prometheus::Histogram>& stageSeconds_;
    prometheus::Histogram& queueSeconds_;
    prometheus::Histogram& iterations_;
    prometheus::Histogram& voxels_;
    prometheus::Histogram& triangles_;
    prometheus::Histogram& outputBytes_;
    std::mutex reading_;  ///< one reader at a time brings counters up to date
};

}  // namespace rivage::server
