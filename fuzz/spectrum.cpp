/// Spectra in files, and what becomes of them in RGB.

#include "io/mitsuba/spectrum.h"

#include "io/mitsuba/values.h"
#include "sandbox.h"

using namespace metrolux::core;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const fuzz::Sandbox sandbox;
    const auto file = sandbox.write("values.spd", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        const mitsuba::SpectrumValue spectrum = mitsuba::readSpectrumFile(file);
        const Rgb reflectance = mitsuba::reflectanceFromSpectrum(spectrum);
        if (!(maxComponent(reflectance) <= 1)) fuzz::fail("a reflectance above one");
        mitsuba::emissionFromSpectrum(spectrum);
    });
    return 0;
}
