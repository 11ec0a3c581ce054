# SPDX-License-Identifier: GPL-3.0-or-later
# a judge of intersecting triangles; apart, since CGAL puts -frounding-math on its whole target
add_library(cgal_pairs STATIC support/cgal_pairs.cpp)
target_link_libraries(cgal_pairs PUBLIC haptic_proto PRIVATE CGAL::CGAL)
set_target_properties(cgal_pairs PROPERTIES JOB_POOL_COMPILE heavy)
