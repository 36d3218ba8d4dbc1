#pragma once

/// Runs the command of these words, the program's name first. Returns the exit status.
extern "C" __attribute__((visibility("default"))) int metroluxCommandLine(int argc, char** argv);
