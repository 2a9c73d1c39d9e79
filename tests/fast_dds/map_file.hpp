// Reads a map of a map server, a .yaml with its .pgm, as the trinary rule has it.
#pragma once

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "messages.hpp"

inline OccupancyGrid read_map(const std::string& path)
{
    std::ifstream yaml(path);
    std::map<std::string, std::string> words;
    for (std::string line; std::getline(yaml, line);) {
        const auto colon = line.find(':');
        if (colon != std::string::npos) {
            const auto begin = line.find_first_not_of(" [", colon + 1);
            words[line.substr(0, colon)] = begin == std::string::npos ? "" : line.substr(begin);
        }
    }
    OccupancyGrid grid{};
    grid.header.frame_id = "map";
    grid.resolution = std::stof(words.at("resolution"));
    double yaw = 0.0;
    char comma;
    std::istringstream origin(words.at("origin"));
    if (!(origin >> grid.position.x >> comma >> grid.position.y >> comma >> yaw)) {
        throw std::runtime_error(path + ": origin is not three numbers");
    }
    grid.orientation = {0.0, 0.0, std::sin(yaw / 2), std::cos(yaw / 2)};

    const std::string image_path = path.substr(0, path.find_last_of('/') + 1) + words.at("image");
    std::ifstream image(image_path, std::ios::binary);
    std::string magic;
    int most;
    image >> magic >> grid.width >> grid.height >> most;
    image.get();
    std::string pixels(size_t{grid.width} * grid.height, '\0');
    if (magic != "P5" || most != 255 || !image.read(pixels.data(), static_cast<std::streamsize>(pixels.size()))) {
        throw std::runtime_error(image_path + ": no PGM of bytes");
    }
    // The image begins with the highest row, the message with the lowest.
    for (uint32_t row = grid.height; row-- > 0;) {
        for (uint32_t column = 0; column < grid.width; ++column) {
            const double p = (255 - static_cast<uint8_t>(pixels[size_t{row} * grid.width + column])) / 255.0;
            grid.data.push_back(p > 0.65 ? 100 : p < 0.196 ? 0 : 255);
        }
    }
    return grid;
}
