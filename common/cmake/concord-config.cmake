# The installed package: find_package(concord).
list(PREPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
include(${CMAKE_CURRENT_LIST_DIR}/concord_dependencies.cmake)
list(POP_FRONT CMAKE_MODULE_PATH)
find_package(nlohmann_json REQUIRED)
include(${CMAKE_CURRENT_LIST_DIR}/concord-targets.cmake)
