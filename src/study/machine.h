#pragma once
#include <nlohmann/json.hpp>

namespace metrolux::core::study {

/// What measured times depend on: processor, its cores, threads that work, memory, system, compiler and its
/// flags, versions of libraries, revision of the program, and the load of the machine now (mean over a
/// minute), which should be low.
nlohmann::json describeMachine(int threads);

/// Now, in UTC: "2026-11-22T07:15:37Z".
std::string timestamp();

}  // namespace metrolux::core::study
