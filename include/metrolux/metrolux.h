#pragma once
/// Metrolux as a library: a Scene is loaded or made, a Session renders it pass by pass. docs/reference/api.md
/// has an example of the whole.
///
/// All functions throw Error (or std::bad_alloc) and nothing else. Different objects may be used by different
/// threads at once; a Session by one at a time, but for Session::requestStop().

#include <metrolux/error.h>
#include <metrolux/image.h>
#include <metrolux/log.h>
#include <metrolux/object.h>
#include <metrolux/scene.h>
#include <metrolux/session.h>
#include <metrolux/version.h>
