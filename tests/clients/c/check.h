// SPDX-License-Identifier: GPL-3.0-or-later
#ifndef TESTS_CLIENTS_C_CHECK_H
#define TESTS_CLIENTS_C_CHECK_H

#include <stdio.h>
#include <stdlib.h>

// Ends the test where the condition does not hold.
#define CHECK(condition)                                                                     \
  do {                                                                                       \
    if (!(condition)) {                                                                      \
      fprintf(stderr, "%s:%d: %s; %s\n", __FILE__, __LINE__, #condition, hapticd_message()); \
      exit(1);                                                                               \
    }                                                                                        \
  } while (0)

#endif
