#include "command.h"

#include "image/image_io.h"
#include "paths.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;

std::string contentOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

}  // namespace

const char* const kTinyScene = R"(<scene version="3.0.0">
    <default name="width" value="24"/>
    <default name="red" value="0.8"/>
    <integrator type="path"><integer name="max_depth" value="8"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="50"/>
        <transform name="to_world"><lookat origin="0, 1, -4" target="0, 0.8, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="$width"/><integer name="height" value="16"/>
            <rfilter type="gaussian"/></film>
        <sampler type="independent"/>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="2"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="$red, 0.6, 0.5"/></bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale value="2"/><rotate y="1" angle="180"/><translate z="2" y="2"/></transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.3, 0.5, 0.7"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="0" y="0.6" z="0"/><float name="radius" value="0.5"/>
        <bsdf type="dielectric"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="90"/><scale value="0.5"/><translate y="2.5"/></transform>
        <emitter type="area"><rgb name="radiance" value="10, 9, 8"/></emitter>
    </shape>
</scene>
)";

Command::Command(const fs::path& folder, const Words& arguments, const Words& launcher) {
    static std::atomic<int> counter{0};
    const std::string name = ".run" + std::to_string(counter++);
    out_ = folder / (name + ".out");
    err_ = folder / (name + ".err");
    Words words = launcher + Words{std::string(METROLUX_BINARY_DIR) + "/metrolux"} + arguments;
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ != 0) return;
    const int out = ::open(out_.c_str(), O_WRONLY | O_CREAT, 0666),
              err = ::open(err_.c_str(), O_WRONLY | O_CREAT, 0666);
    ::dup2(out, 1);
    ::dup2(err, 2);
    if (::chdir(folder.c_str()) == 0) ::execvp(argv[0], argv.data());
    ::_exit(127);
}

Command::~Command() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
}

void Command::signal(int number) const { ::kill(pid_, number); }

Outcome Command::wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), contentOf(out_),
            contentOf(err_)};
}

CliTest::CliTest() { write("scene.xml", kTinyScene); }

std::vector<float> CliTest::pixels(const std::string& image) const {
    return readImage(folder / image, false).pixels;
}

bool CliTest::waitFor(const std::string& name) const {
    for (int i = 0; i < 6000; ++i) {
        if (fs::exists(folder / name)) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

}  // namespace metrolux::core::cli
