#pragma once

namespace carat {

// Lets other threads of the process go first: a frame that waits for workers must be woken at its deadline
// while they go on. No effect where the system does not know priorities of threads.
void lower_thread_priority();

}  // namespace carat
