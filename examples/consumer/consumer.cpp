// Points in, textured mesh out, in one call each.
#include <pointbake/convert.h>
#include <pointbake/load.h>
#include <pointbake/write.h>

#include <iostream>

int main(int argc, char** argv) {
    if (argc != 3) {
        std::cerr << "usage: consumer CLOUD.ply MODEL.glb\n";
        return 2;
    }
    pointbake::ConvertOptions options;
    options.simplify.triangles = 2000;
    pointbake::ConvertInput input;
    input.cloud = pointbake::load_cloud(argv[1]).cloud;
    const pointbake::ConvertResult result = pointbake::convert(std::move(input), options);
    pointbake::write_model(result.model, argv[2]);
    std::cout << result.model.mesh.triangles.size() << " triangles\n";
}
