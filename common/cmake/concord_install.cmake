# `cmake --install FOLDER` installs the program, the models, the manual, and the libraries as a package:
# find_package(concord) gives another project concord::cartesian and concord::relative, the joint vocabulary
# (concord::common), the comparator (concord::verdict, its tables and files: concord::report, the invariance checks:
# concord::invariance) and the joint check (concord::joint_check).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/concord)
set(libraries concord_options)
foreach(library common sundials cartesian relative audit attribution quantities states resolution verdict equilibrium report
                analyses invariance joint_check)
  if(TARGET concord_${library})
    set_target_properties(concord_${library} PROPERTIES EXPORT_NAME ${library})
    list(APPEND libraries concord_${library})
  endif()
endforeach()
set_target_properties(concord_options PROPERTIES EXPORT_NAME options)
install(TARGETS ${libraries} EXPORT concord ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT concord NAMESPACE concord:: DESTINATION ${package} FILE concord-targets.cmake)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/concord-config-version.cmake COMPATIBILITY SameMinorVersion)
configure_file(${CMAKE_CURRENT_LIST_DIR}/concord-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/concord-config.cmake @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/concord-config.cmake ${CMAKE_CURRENT_LIST_DIR}/concord_dependencies.cmake
              ${CMAKE_CURRENT_LIST_DIR}/FindSuiteSparse.cmake ${CMAKE_CURRENT_BINARY_DIR}/concord-config-version.cmake
        DESTINATION ${package})

# The public interface, and what its headers include; all other headers stay inside.
set(public_headers cartesian/solver.h relative/solver.h common/reading/model_file.h common/joints/by_function.h
                   common/joints/catalogue.h compare/verdict/verify.h compare/report/table.h compare/report/result_files.h
                   compare/invariance/invariance_checks.h compare/joint_check/sheet.h)
set(installed "")
while(public_headers)
  list(POP_FRONT public_headers header)
  if(header IN_LIST installed OR NOT EXISTS ${PROJECT_SOURCE_DIR}/${header})
    continue()  # a solver may be absent
  endif()
  list(APPEND installed ${header})
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION include/concord/${folder})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
  file(STRINGS ${PROJECT_SOURCE_DIR}/${header} includes REGEX "^#include \"")
  list(TRANSFORM includes REPLACE "^#include \"([^\"]*)\".*" "\\1")
  list(APPEND public_headers ${includes})
endwhile()

# The manual with its links, and the models beside the pages that explain them.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/data DESTINATION ${CMAKE_INSTALL_DOCDIR})
file(GLOB_RECURSE pages RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS
     ${PROJECT_SOURCE_DIR}/common/*.md ${PROJECT_SOURCE_DIR}/cartesian/*.md
     ${PROJECT_SOURCE_DIR}/relative/*.md ${PROJECT_SOURCE_DIR}/compare/*.md ${PROJECT_SOURCE_DIR}/tests/*.md)
list(PREPEND pages README.md)
foreach(page IN LISTS pages)
  cmake_path(GET page PARENT_PATH folder)
  install(FILES ${PROJECT_SOURCE_DIR}/${page} DESTINATION ${CMAKE_INSTALL_DOCDIR}/${folder})
endforeach()
if(TARGET concord)
  install(TARGETS concord RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(FILES ${PROJECT_BINARY_DIR}/compare/program/concord.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${PROJECT_SOURCE_DIR}/compare/program/completion.bash
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME concord)
endif()
