// Ctrl-C: long work ends at its next progress report.
#pragma once

namespace carat::cli {

// From now on SIGINT and SIGTERM set a flag instead of ending the program; a second one ends it at once.
void catch_interrupts();
// True once a signal has come.
bool interrupted();

}  // namespace carat::cli
