/// The program: all of it is in command_line.cpp, which packages put into a library, once for each kind of
/// processor.

#include "app/command_line.h"

int main(int argc, char** argv) { return metroluxCommandLine(argc, argv); }
