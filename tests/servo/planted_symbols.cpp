// SPDX-License-Identifier: GPL-3.0-or-later
// Forbidden calls in the servo's step, for the test that tests/symbols.cmake refuses them.
#include <pthread.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace haptic {

double ring_up(double x);  // a function of this project, but not among the objects

double plant_everything(double x, pthread_mutex_t* mutex, std::vector<double>& values,
                        void*& memory) {
  pthread_mutex_lock(mutex);
  std::printf("%g\n", x);
  values.push_back(std::sin(x));
  if (x < 0) throw x;
  std::free(memory);
  memory = std::malloc(static_cast<size_t>(x));
  return ring_up(x);
}

}  // namespace haptic
