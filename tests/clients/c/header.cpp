// SPDX-License-Identifier: GPL-3.0-or-later
// The header by itself is C++ too, and the structs have no holes whose bytes nobody has set.
#include <hapticd/client_c.h>

template <typename T>
constexpr bool has_words(size_t words) {
  return sizeof(T) == 8 * words;
}
static_assert(has_words<hapticd_pose>(7) && has_words<hapticd_twist>(6), "");
static_assert(has_words<hapticd_servo>(1 + 3 + 7 + 6 + 7 + 6 + 6 + 7 + 6 + 1 + 2), "");
static_assert(has_words<hapticd_contact_set>(1 + 3 + 7 + 7 + 2), "");
static_assert(has_words<hapticd_contact>(1 + 3 + 3 + 3 + 2), "");
static_assert(has_words<hapticd_scene>(1 + 2 + 1) && has_words<hapticd_object>(2 + 7 + 6 + 1), "");
static_assert(has_words<hapticd_control>(1 + 2 + 5 + 2) && has_words<hapticd_push>(3 + 6 + 6), "");
static_assert(has_words<hapticd_motion>(1 + 7 + 6 + 6 + 3 * 36 + 1), "");

int main() {
  return hapticd_message()[0];
}
