# `cmake --install FOLDER` installs the program, and the libraries as a package: find_package(concord) gives another
# project concord::cartesian and concord::relative, the joint vocabulary (concord::common), the comparator
# (concord::verdict, its tables and files: concord::report, the invariance battery: concord::invariance) and the joint
# check (concord::joint_check).
include(GNUInstallDirs)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/concord)
set(libraries concord_options)
foreach(library common sundials cartesian relative audit attribution verdict equilibrium report analyses invariance
                joint_check)
  if(TARGET concord_${library})
    set_target_properties(concord_${library} PROPERTIES EXPORT_NAME ${library})
    list(APPEND libraries concord_${library})
  endif()
endforeach()
set_target_properties(concord_options PROPERTIES EXPORT_NAME options)
install(TARGETS ${libraries} EXPORT concord ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT concord NAMESPACE concord:: DESTINATION ${package} FILE concord-targets.cmake)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/concord-config.cmake ${CMAKE_CURRENT_LIST_DIR}/concord_dependencies.cmake
              ${CMAKE_CURRENT_LIST_DIR}/FindSuiteSparse.cmake DESTINATION ${package})
foreach(folder common cartesian relative compare)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder} DESTINATION include/concord FILES_MATCHING PATTERN "*.h")
endforeach()
if(TARGET concord)
  install(TARGETS concord RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
