#pragma once
/// Options of commands whose rendering can be watched.

#include "app/render_options.h"
#include "view/live_view.h"

namespace metrolux::core::app {

/// --serve, --serve-address, --tev.
void addServeOptions(CLI::App& app, LiveArguments& a);
/// The same for a command that always serves: --port in place of --serve, and --no-open.
void addPortOptions(CLI::App& app, LiveArguments& a);
/// Throws Error for a port that cannot be.
view::LiveOptions liveOptions(const LiveArguments& a);
/// Prints the address of the page, whatever else is to be quiet.
void tellPage(const std::string& url);
/// What viewers are told of a rendering.
view::BoardInfo boardInfo(const RenderArguments& a);

}  // namespace metrolux::core::app
