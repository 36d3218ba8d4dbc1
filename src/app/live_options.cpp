#include "app/live_options.h"

#include "base/error.h"

#include <algorithm>
#include <charconv>

namespace metrolux::core::app {
namespace {

constexpr const char* kGroup = "Live view (docs/how-to/watch-a-render.md)";

/// Returns --serve-address.
CLI::Option* addOthers(CLI::App& app, LiveArguments& a) {
    app.add_option("--tev", a.tev, "Show the image in tev, an image viewer that listens there")
        ->option_text("HOST:PORT")
        ->group(kGroup);
    return app
        .add_option("--serve-address", a.address,
                    "Address of this machine to listen on (default: 127.0.0.1, for programs of this\n"
                    "machine only). Beyond it the page's address has a token, without which nothing is shown")
        ->option_text("ADDRESS")
        ->group(kGroup);
}

}  // namespace

void addServeOptions(CLI::App& app, LiveArguments& a) {
    app.add_option_function<std::string>(
           "--serve",
           [&a](const std::string& port) {
               a.serves = true;
               a.port = port;
           },
           "Serve a page that shows the image while it is rendered, on this port (default: one\n"
           "that is free)")
        ->option_text("[PORT]")
        ->expected(0, 1)
        ->group(kGroup);
    addOthers(app, a)->needs("--serve");
}

void addPortOptions(CLI::App& app, LiveArguments& a) {
    a.serves = true;
    app.add_option("--port", a.port, "Port of the page (default: one that is free)")
        ->option_text("PORT")
        ->group(kGroup);
    app.add_flag("--no-open", a.staysClosed, "Print the page's address, and do not open it")->group(kGroup);
    addOthers(app, a);
}

view::LiveOptions liveOptions(const LiveArguments& a) {
    view::LiveOptions options;
    options.serves = a.serves;
    options.tev = a.tev;
    if (!a.address.empty()) options.address = a.address;
    if (!a.port.empty()) {
        const auto [end, code] = std::from_chars(a.port.data(), a.port.data() + a.port.size(), options.port);
        if (code != std::errc() || end != a.port.data() + a.port.size() || options.port == 0)
            throw Error("'{}' is not a port, expected a number from 1 to 65535", a.port);
    }
    return options;
}

void tellPage(const std::string& url) { fmt::print(stderr, "The page is at {}\n", url); }

view::BoardInfo boardInfo(const RenderArguments& a) {
    view::BoardInfo info;
    info.scene = sceneName(a.scene);
    info.outputs = a.outputs;
    for (const std::string& name : a.session.layers)
        if (isShown(aovFromName(name))) info.layers.push_back(name);
    return info;
}

}  // namespace metrolux::core::app
