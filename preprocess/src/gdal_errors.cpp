#include "gdal_errors.hpp"

#include <cpl_error.h>
#include <gdal.h>

#include <mutex>

namespace carat {
namespace {

void CPL_STDCALL keep_error(CPLErr severity, CPLErrorNum, const char* message) {
    static_cast<GdalErrors*>(CPLGetErrorHandlerUserData())->keep(severity, message);
}

}  // namespace

void initialise_gdal() {
    static std::once_flag once;
    std::call_once(once, [] { GDALAllRegister(); });
}

GdalErrors::GdalErrors() { CPLPushErrorHandlerEx(keep_error, this); }
GdalErrors::~GdalErrors() { CPLPopErrorHandler(); }

std::string GdalErrors::text() const {
    if (!failure_.empty()) return failure_;
    return warning_.empty() ? "no reason given" : warning_;
}

void GdalErrors::keep(int severity, const char* message) {
    std::string& kept = severity >= CE_Failure ? failure_ : warning_;
    if (severity >= CE_Warning && kept.empty())
        kept = message != nullptr && *message != 0 ? message : "error";
}

}  // namespace carat
