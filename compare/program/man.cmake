# Writes the man page from what --help says, so that both say the same: cmake -D PROGRAM=<concord> -D PAGE=<concord.1>
# -D VERSION=<0.1.0> -P man.cmake
cmake_minimum_required(VERSION 3.25)

function(ask result)
  execute_process(COMMAND ${PROGRAM} ${ARGN} --help OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
  set(${result} "${said}" PARENT_SCOPE)
endfunction()

# As it is printed, each line as it stands.
function(section title text)
  string(REPLACE "\\" "\\e" text "${text}")
  string(REGEX REPLACE "(^|\n)([.'])" "\\1\\\\&\\2" text "${text}")
  string(REPLACE "-" "\\-" text "${text}")
  string(APPEND page ".SH ${title}\n.nf\n${text}\n.fi\n")
  set(page "${page}" PARENT_SCOPE)
endfunction()

ask(about)
string(REGEX MATCH "\nSubcommands:\n(.*)\n\nExamples" commands "${about}")
string(REGEX MATCHALL "\n  [a-z]+ " names "\n${CMAKE_MATCH_1}")
set(page ".TH CONCORD 1 \"\" \"concord ${VERSION}\" \"User commands\"\n.SH NAME\nconcord \\- two independent multibody solvers, \
every joint reaction compared\n")
section(USAGE "${about}")
foreach(name IN LISTS names)
  string(STRIP "${name}" name)
  ask(help ${name})
  string(TOUPPER "${name}" title)
  section(${title} "${help}")
endforeach()
file(WRITE ${PAGE} "${page}")
