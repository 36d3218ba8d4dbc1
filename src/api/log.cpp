#include "api/log.h"

#include <mutex>

namespace metrolux {
namespace {

struct Receiver {
    std::mutex mutex;
    std::function<void(LogLevel, const std::string&)> call;
};

Receiver& receiver() {
    static Receiver instance;
    return instance;
}

}  // namespace

void setLog(std::function<void(LogLevel, const std::string&)> call) {
    const std::lock_guard lock(receiver().mutex);
    receiver().call = std::move(call);
}

void core::api::log(LogLevel level, const std::string& message) {
    const std::lock_guard lock(receiver().mutex);
    if (receiver().call) receiver().call(level, message);
}

}  // namespace metrolux
