# Looks for what the Python module is built with: pybind11 and the development files of one Python, Debian's where it is
# there (another one may come first on PATH, for which no numpy is installed); -DPython3_EXECUTABLE=... chooses another.
option(CONCORD_PYTHON "Build the Python module, where pybind11 and Python's development files are" ON)
set(CONCORD_HAS_PYTHON OFF)
set(CONCORD_PYTHON_EXECUTABLE "" CACHE INTERNAL "The Python that the module is built for")
if(CONCORD_PYTHON AND NOT CONCORD_SANITIZE)  # a sanitized module does not load into a Python that is not
  if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
    set(Python3_EXECUTABLE /usr/bin/python3)
  endif()
  find_package(Python3 QUIET COMPONENTS Interpreter Development.Module)
  if(Python3_FOUND)
    find_package(pybind11 2.10 CONFIG QUIET)
  endif()
  if(Python3_FOUND AND pybind11_FOUND)
    set(CONCORD_HAS_PYTHON ON)
    set(CONCORD_PYTHON_EXECUTABLE ${Python3_EXECUTABLE} CACHE INTERNAL "The Python that the module is built for")
    # The libraries become part of a shared one. Nothing in it is replaced from outside, so that g++ may inline as before.
    set(CMAKE_POSITION_INDEPENDENT_CODE ON)
    add_compile_options($<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)
    message(STATUS "Python module: for ${Python3_EXECUTABLE}, version ${Python3_VERSION}")
  else()
    message(STATUS "Python module: left out, pybind11-dev or python3-dev is missing")
  endif()
endif()
