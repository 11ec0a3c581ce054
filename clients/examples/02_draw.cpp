// SPDX-License-Identifier: Apache-2.0
// Draws a session as it is now into an SVG: 02_draw FILE.svg [session]. The view is along −z of W:
// (x, y) lies at (1000 x, −1000 y), in millimetres. The red line is the spring's force on the tool,
// 10 mm for each newton.
#include <hapticd/client.h>

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

using namespace haptic;

/// The triangles that face the viewer, as one path in the colour of the mesh.
void draw(std::FILE* svg, const EyeMesh& mesh, const Pose& X_W) {
  const auto byte = [](float share) { return static_cast<unsigned>(255 * share + 0.5f); };
  std::fprintf(svg, "<path fill=\"#%02x%02x%02x\" d=\"", byte(mesh.colour.r), byte(mesh.colour.g),
               byte(mesh.colour.b));
  const auto corner = [&](uint32_t vertex) {
    const EyePoint& v = mesh.vertices[vertex];
    return 1e3 * (X_W * Vec3{v[0], v[1], v[2]});
  };
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 a = corner(i), b = corner(j), c = corner(k);
    if (cross(b - a, c - a).z <= 0) continue;
    std::fprintf(svg, "M%.2f %.2fL%.2f %.2fL%.2f %.2fZ", a.x, -a.y, b.x, -b.y, c.x, -c.y);
  }
  std::fprintf(svg, "\"/>\n");
}

int main(int argc, char** argv) try {
  if (argc < 2) throw std::runtime_error("say where to draw: 02_draw FILE.svg [session]");
  Client client(argc > 2 ? argv[2] : "");  // no name: the only session that runs
  auto frames = client.ring<&ServoChannels::frames>(Start::kNewest);
  auto scenes = client.ring<&SimChannels::frames>(Start::kNewest);
  client.start();
  ServoFrame frame{};
  SceneFrame scene{};
  Eyes eyes;
  for (bool complete = false; !complete; eyes = client.eyes()) {
    client.sleep(0.05);
    if (!client.is_connected()) throw std::runtime_error("the session is gone " + client.refusal());
    complete = frames.latest(frame) && scenes.latest(scene) && eyes.tools[0];
    for (size_t i = 0; i < scene.objects.size(); ++i) complete = complete && eyes.objects[i];
  }
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> svg(std::fopen(argv[1], "w"), std::fclose);
  if (!svg) throw std::runtime_error("cannot write " + shown(argv[1]));
  std::fprintf(svg.get(),
               "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-200 -200 400 400\">\n");
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    draw(svg.get(), *eyes.objects[i], scene.objects[i].X_WO);
  }
  draw(svg.get(), *eyes.tools[0], frame.X_WT);
  const Vec3 p = 1e3 * frame.X_WT.p, tip = p + 10.0 * frame.F_coupling_W.f;
  std::fprintf(svg.get(),
               "<line id=\"force\" data-tick=\"%llu\" stroke=\"red\" x1=\"%.4f\" y1=\"%.4f\" "
               "x2=\"%.4f\" y2=\"%.4f\"/>\n</svg>\n",
               static_cast<unsigned long long>(frame.tick), p.x, -p.y, tip.x, -tip.y);
} catch (const std::exception& error) {
  std::fprintf(stderr, "02_draw: %s\n", error.what());
  return 1;
}
