# Adds a word of each kind to a copy of the vocabulary and holds what the compiler then says against the table of
# common/joints/README.md, "Add a primitive": every visit of the listed sources is refused for want of a clause, all sources
# that need no more than facts compile, a word without facts compiles nowhere, and no source tells words apart behind the
# compiler's back. Run as
#   cmake -D SOURCE=<root of the project> -D FOLDER=<where the copy may stand> -D COMPILER=<C++> -D INCLUDES=<a|b|...>
#         -D DEFINITIONS=<a|b|...> -P new_word.cmake
# or, for what is seen in the text of the sources alone, as
#   cmake -D SOURCE=<root of the project> -D FOLDER=<where the copy may stand> -D TEXT_ONLY=ON -P new_word.cmake
cmake_minimum_required(VERSION 3.25)

set(breaches "")
function(breach text)
  string(APPEND breaches "\n  ${text}")
  set(breaches "${breaches}" PARENT_SCOPE)
endfunction()

# The kinds of words, and the words of each, as the variants of the vocabulary name them.
file(READ ${SOURCE}/common/joints/vocabulary.h vocabulary)
set(kinds Forbid ForbidSpeed Permit PermitSpeed Read)
set(words "")
foreach(kind IN LISTS kinds)
  if(NOT vocabulary MATCHES "using ${kind} =[^<]*std::variant<([^>]*)>")
    message(FATAL_ERROR "vocabulary.h does not state ${kind} as a variant")
  endif()
  string(REGEX REPLACE "[ \n]" "" named "${CMAKE_MATCH_1}")
  string(REPLACE "," ";" named "${named}")
  list(APPEND words ${named})
endforeach()
list(JOIN words "|" any_word)

# The copy: one new word of each kind, with its facts or, where BARE is defined, without.
set(facts_of_Forbid [[
  static constexpr int rows() { return 1; }
  static constexpr double stated_length() { return 0.0; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }]])
set(facts_of_ForbidSpeed [[
  static constexpr int rows() { return 1; }
  static constexpr double stated_length() { return 0.0; }
  static constexpr bool is_seen_from_child() { return false; }]])
set(facts_of_Permit [[
  static constexpr StatedCoordinates coordinates() { return StatedCoordinates({CoordinateKind::angle, "new"}); }
  static constexpr double stated_length() { return 0.0; }
  static constexpr std::optional<Axis> arm() { return {}; }
  static constexpr const FunctionOfCoordinates* function() { return nullptr; }]])
set(facts_of_PermitSpeed [[
  static constexpr CoordinateKind kind() { return CoordinateKind::angle; }
  static constexpr double stated_length() { return 0.0; }]])
set(facts_of_Read [[
  static constexpr CoordinateKinds kinds() { return CoordinateKinds(CoordinateKind::angle); }
  static constexpr Push pushed_by() { return Push::torque; }
  static constexpr bool is_elevation() { return false; }
  static constexpr const FunctionOfPlacement* function() { return nullptr; }
  static constexpr WrenchesOfPlacement stated_wrenches() { return nullptr; }]])
set(extended "${vocabulary}")
foreach(kind IN LISTS kinds)
  set(word "struct New${kind} {\n#ifndef BARE\n${facts_of_${kind}}\n#endif\n};\n\n")
  string(REGEX REPLACE "using ${kind} =([^<]*)std::variant<" "${word}using ${kind} =\\1std::variant<New${kind}, "
         extended "${extended}")
endforeach()
file(WRITE ${FOLDER}/common/joints/vocabulary.h "${extended}")

# What the manual lists: rows of the form | `path` | kinds | ... of its table.
file(STRINGS ${SOURCE}/common/joints/README.md rows REGEX "^\\| `[a-z_/]+\\.cpp` \\| [A-Z]")
set(listed "")
foreach(row IN LISTS rows)
  string(REGEX MATCH "^\\| `([^`]+)` \\| ([^|]+) \\|" row "${row}")
  set(source ${CMAKE_MATCH_1})
  string(REGEX MATCHALL "[A-Za-z]+" wanted_of_${source} "${CMAKE_MATCH_2}")
  list(SORT wanted_of_${source})
  list(APPEND listed ${source})
endforeach()

# Sources with clauses of words must be listed, none may tell words apart in any other way.
file(GLOB_RECURSE sources RELATIVE ${SOURCE} ${SOURCE}/common/*.cpp ${SOURCE}/common/*.h ${SOURCE}/cartesian/*.cpp
     ${SOURCE}/cartesian/*.h ${SOURCE}/relative/*.cpp ${SOURCE}/relative/*.h ${SOURCE}/compare/*.cpp
     ${SOURCE}/compare/*.h)
set(by_facts "")
foreach(source IN LISTS sources)
  file(READ ${SOURCE}/${source} text)
  if(text MATCHES "(holds_alternative|get_if|std::get)<(const )?(concord::)?(joints::)?(${any_word})>")
    breach("${source} tells words apart by ${CMAKE_MATCH_1}<${CMAKE_MATCH_5}>, which lets a new word pass in silence")
  endif()
  if(source STREQUAL "common/joints/facts.h" OR source IN_LIST listed)
    continue()
  endif()
  if(text MATCHES "const (concord::)?(joints::)?(${any_word})&")
    breach("${source} has a clause of ${CMAKE_MATCH_3}, but the table does not list it")
  elseif(source MATCHES "\\.cpp$" AND NOT source MATCHES "^compare/oracle/" AND  # which is no C++20
         text MATCHES "stated_coordinates|kinds_of|kind_of|is_orientation|is_length|is_elevation|function_of\\(|home_of")
    list(APPEND by_facts ${source})
  endif()
endforeach()

list(LENGTH listed n_listed)
list(LENGTH by_facts n_by_facts)
if(TEXT_ONLY)
  if(breaches)
    message(FATAL_ERROR "The words of the vocabulary:${breaches}")
  endif()
  message(STATUS "clauses of words stand in the ${n_listed} sources of the table; ${n_by_facts} others read facts")
  return()
endif()

set(options -std=c++20 -fsyntax-only -I${FOLDER} -I${SOURCE})
string(REPLACE "|" ";" folders "${INCLUDES}")
list(REMOVE_ITEM folders "" ${SOURCE} /usr/include)
list(REMOVE_DUPLICATES folders)
list(TRANSFORM folders PREPEND "-isystem" OUTPUT_VARIABLE includes)
string(REPLACE "|" ";" definitions "${DEFINITIONS}")
list(REMOVE_ITEM definitions "")
list(TRANSFORM definitions PREPEND "-D")
execute_process(COMMAND ${COMPILER} --version OUTPUT_VARIABLE version)
if(version MATCHES "clang")
  list(APPEND options -ferror-limit=0)
endif()
# What nearly all of them read first, and what no word changes, is read once.
file(WRITE ${FOLDER}/headers.h "#include <Eigen/Dense>\n#include <fmt/format.h>\n#include <functional>\n#include <optional>\n"
                               "#include <string>\n#include <variant>\n#include <vector>\n")
execute_process(COMMAND ${COMPILER} -std=c++20 ${includes} ${definitions} -x c++-header ${FOLDER}/headers.h
                        -o ${FOLDER}/headers.h.gch COMMAND_ERROR_IS_FATAL ANY)
list(APPEND options -include ${FOLDER}/headers.h)
function(compile what said failed)
  execute_process(COMMAND ${COMPILER} ${options} ${includes} ${definitions} ${ARGN} ${what}
                  RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE text)
  set(${said} "${text}" PARENT_SCOPE)
  set(${failed} ${result} PARENT_SCOPE)
endfunction()

# Every visit of the listed sources is refused, for the kinds of the table and no others.
foreach(source IN LISTS listed)
  compile(${SOURCE}/${source} said failed)
  set(refused "")
  foreach(kind IN LISTS kinds)
    if(said MATCHES "New${kind}[^A-Za-z]")
      list(APPEND refused ${kind})
    endif()
  endforeach()
  list(SORT refused)
  if(NOT refused STREQUAL "${wanted_of_${source}}")
    breach("${source}: the table lists [${wanted_of_${source}}], the compiler asks for [${refused}]")
  endif()
  set(number 0)
  set(visits 0)
  file(READ ${SOURCE}/${source} text)
  string(REPLACE ";" "" text "${text}")
  string(REPLACE "[" "(" text "${text}")
  string(REPLACE "]" ")" text "${text}")
  string(REPLACE "\n" ";" lines "${text}")
  foreach(line IN LISTS lines)
    math(EXPR number "${number} + 1")
    if(line MATCHES "std::visit\\(")
      math(EXPR visits "${visits} + 1")
      string(FIND "${said}" "${source}:${number}:" at)
      if(at EQUAL -1)
        breach("${source}:${number}: this visit takes a new word in silence")
      endif()
    endif()
  endforeach()
  if(visits EQUAL 0)
    breach("${source} visits nothing, but the table lists it")
  endif()
endforeach()

# What needs facts only compiles with new words: joined, as many sources as the folder has in one.
set(folders "")
foreach(source IN LISTS by_facts)
  cmake_path(GET source PARENT_PATH folder)
  string(REPLACE "/" "_" folder ${folder})
  list(APPEND folders ${folder})
  string(APPEND joined_${folder} "#include \"${source}\"\n")
endforeach()
list(REMOVE_DUPLICATES folders)
foreach(folder IN LISTS folders)
  file(WRITE ${FOLDER}/${folder}.cpp "${joined_${folder}}")
  compile(${FOLDER}/${folder}.cpp said failed)
  if(failed)
    breach("with new words these do not compile, though they need facts only:\n${joined_${folder}}${said}")
  endif()
endforeach()

# Without facts nothing compiles.
compile(${SOURCE}/common/joints/facts.cpp said failed -DBARE)
foreach(kind IN LISTS kinds)
  if(NOT said MATCHES "no member named '[a-z_]+' in 'concord::joints::New${kind}'" AND
     NOT said MATCHES "New${kind}.* has no member named")
    breach("a word of kind ${kind} without facts is not refused")
  endif()
endforeach()

if(breaches)
  message(FATAL_ERROR "A new word:${breaches}")
endif()
message(STATUS "a new word is asked for by the ${n_listed} sources of the table; ${n_by_facts} others need its facts only")
