# Conan 2: conan create cmake/packaging/conan
import os

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeToolchain
from conan.tools.files import copy, load


class Semiexplicit(ConanFile):
    name = "semiexplicit"
    description = "Symplectic integration of non-separable Hamiltonian systems"
    license = "MIT"
    topics = ("hamiltonian", "symplectic", "ode", "header-only")
    package_type = "header-library"
    settings = "os", "arch", "compiler", "build_type"
    generators = "CMakeDeps"
    requires = "eigen/[>=3.4]"
    no_copy_source = True

    def _root(self):
        return os.path.normpath(os.path.join(self.recipe_folder, "..", "..", ".."))

    def set_version(self):
        # The one place of the version is the header.
        words = load(self, os.path.join(self._root(), "include", "semiexplicit", "version.hpp")).split()
        parts = [words[words.index("SEMIEXPLICIT_VERSION_" + part) + 1] for part in ("MAJOR", "MINOR", "PATCH")]
        self.version = ".".join(parts)

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "include/*", "cmake/*"):
            copy(self, pattern, self._root(), self.export_sources_folder)

    def validate(self):
        check_min_cppstd(self, 20)

    def package_id(self):
        self.info.clear()  # headers are the same for every compiler

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in ("TESTS", "EXAMPLES", "BENCHMARKS"):
            toolchain.cache_variables["SEMIEXPLICIT_BUILD_" + part] = False
        toolchain.generate()

    def build(self):
        CMake(self).configure()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        self.cpp_info.bindirs = []
        self.cpp_info.libdirs = []
        # find_package(semiexplicit) finds the package's own files, with their components.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("share", "cmake", "semiexplicit")]
        self.cpp_info.set_property("pkg_config_name", "semiexplicit")
