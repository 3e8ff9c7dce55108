// An independent reader of geographic rasters: GDAL's pixels and the textbook bilinear formula, nothing of
// Carat's.
#pragma once

#include <string>
#include <vector>

namespace carat::test {

class BilinearReader {
  public:
    // A north-up raster in latitude and longitude, pixel-is-area, read whole.
    explicit BilinearReader(const std::string& path);

    // Height at a place at least half a pixel inside the raster; global rasters wrap in longitude.
    double height(double latitude, double longitude) const;
    // Greatest minus least of the samples within r rows of a place, and as far eastwards and westwards on the
    // ground.
    double relief(double latitude, double longitude, int r) const;

    double west() const { return west_; }
    double north() const { return north_; }
    double east() const { return west_ + step_x_ * width_; }
    double south() const { return north_ + step_y_ * height_; }
    double pixel() const { return step_x_; }  // degrees

  private:
    double sample(int column, int row) const;

    int width_ = 0, height_ = 0;
    double west_ = 0, north_ = 0, step_x_ = 0, step_y_ = 0;
    bool global_ = false;
    std::vector<float> pixels_;
};

}  // namespace carat::test
