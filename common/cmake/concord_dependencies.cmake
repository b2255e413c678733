# What the libraries are built on, and what a project that finds the installed package needs there, too.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(SUNDIALS 6.4 REQUIRED COMPONENTS ida arkode nvecserial sunmatrixdense sunmatrixsparse sunlinsoldense)
find_package(SuiteSparse REQUIRED)
find_library(LAPACK_LIBRARY lapack REQUIRED)  # which SuiteSparse needs, too
find_package(tomlplusplus REQUIRED)
find_package(muparser REQUIRED)
find_package(netCDF REQUIRED)
find_package(fmt REQUIRED)
find_package(spectra-config QUIET)
find_package(Spectra REQUIRED PATHS /usr/share/spectra/cmake)
find_package(Threads REQUIRED)
