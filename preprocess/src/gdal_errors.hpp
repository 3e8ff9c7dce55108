// GDAL's start-up and its error text, kept for our messages instead of being printed.
#pragma once

#include <string>

namespace carat {

// Registers GDAL's drivers, once.
void initialise_gdal();

// While it lives, what GDAL reports in this thread is kept here.
class GdalErrors {
  public:
    GdalErrors();
    ~GdalErrors();
    GdalErrors(const GdalErrors&) = delete;
    GdalErrors& operator=(const GdalErrors&) = delete;

    bool failed() const { return !failure_.empty(); }
    // The first failure, else the first warning, else "no reason given".
    std::string text() const;
    void keep(int severity, const char* message);

  private:
    std::string failure_, warning_;
};

}  // namespace carat
