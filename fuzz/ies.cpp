/// Photometric webs, and lights that are made of them.

#include "io/ies_file.h"
#include "sandbox.h"

using namespace metrolux::core;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const fuzz::Sandbox sandbox;
    const auto file = sandbox.write("web.ies", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        std::vector<std::string> warnings;
        MemoryBudget memory(fuzz::kMemoryBytes);
        const PhotometricWeb web = readIes(file, warnings, &memory);
        for (float vertical = 0; vertical <= 180; vertical += 30)
            for (float horizontal = 0; horizontal < 360; horizontal += 30)
                if (!(web.at(vertical, horizontal) >= 0)) fuzz::fail("a value that is negative");
    });
    return 0;
}
