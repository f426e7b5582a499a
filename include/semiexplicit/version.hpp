#pragma once

// The one place of the version: CMakeLists.txt reads these three lines.
#define SEMIEXPLICIT_VERSION_MAJOR 0
#define SEMIEXPLICIT_VERSION_MINOR 1
#define SEMIEXPLICIT_VERSION_PATCH 0
