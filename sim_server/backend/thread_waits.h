// How the threads of the CPU back end wait for each other.
#pragma once

namespace palp {

// Makes a thread that waits for another one sleep after about a microsecond, unless OMP_WAIT_POLICY or GOMP_SPINCOUNT
// says otherwise. By default it spins for milliseconds, which keeps a core from whom it waits for where other processes
// need cores, too: a step of 1.9 ms then takes 220 ms. OpenMP reads this when it is loaded, before main(): so this
// starts the program anew, in the same process, the first time. To be called first in main() with its argv.
void wait_asleep(char** argv);

}  // namespace palp
