#pragma once
#include "image/image_io.h"

namespace metrolux::core::app {

/// What an image says of itself, for people.
void printImage(const ImageInfo& image);
/// The same as a JSON object.
void printImageJson(const ImageInfo& image);

}  // namespace metrolux::core::app
