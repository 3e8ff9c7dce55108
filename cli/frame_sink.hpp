// Where the frames of a flight go: numbered pictures in a folder, or a film through ffmpeg.
#pragma once

#include <cstdio>
#include <string>

#include "carat/vulkan/picture.hpp"

namespace carat::cli {

class FrameSink {
  public:
    // `output`: "X.mp4" is a film of `fps` frames a second, anything else a folder of frame-00001.png ...
    // (made if missing), or with another extension than "png". Throws Error(usage) if it exists and overwrite
    // is not set, Error(io) if it cannot be made.
    FrameSink(std::string output, double fps, bool overwrite, const std::string& extension = "png");
    ~FrameSink();
    FrameSink(const FrameSink&) = delete;
    FrameSink& operator=(const FrameSink&) = delete;

    // Frames of one size, in order: R, G, B, A. A is written in .exr only. Throws Error(io).
    void add(const Picture& colour);
    // Completes a film under its name. Throws Error(io) with what ffmpeg had to say in its exit status.
    void finish();

  private:
    void open_film(const Picture& first);
    std::string file_of(int frame) const;

    std::string output_, partial_, extension_;
    double fps_;
    bool film_;
    int frames_ = 0;
    std::FILE* pipe_ = nullptr;
};

}  // namespace carat::cli
