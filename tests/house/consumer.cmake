# Installs the build into a scratch prefix; makes, compresses and queries a planet with the installed program; configures,
# builds and runs tests/consumer against the installed package, which must read the same height from the file.
file(REMOVE_RECURSE ${SCRATCH})

# run(what command...): fails with the command's words; leaves its output in `output`.
function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  message("${output}${errors}")
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what} failed: ${result}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(carat ${SCRATCH}/prefix/bin/carat)
set(file ${SCRATCH}/cliff.carat)
set(place 36.5 -118.25)

run("installing" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH}/prefix)
run("carat synth" ${carat} synth cliff -o ${SCRATCH}/planet)
run("carat build" ${carat} build -q --layer ${SCRATCH}/planet/cliff.tif --tolerance 100 -o ${file})
run("carat query" ${carat} query ${file} ${place})
if(NOT output MATCHES "\n[^,\n]*,[^,\n]*,([-0-9.]+),")
  message(FATAL_ERROR "carat query printed no height")
endif()
set(height ${CMAKE_MATCH_1})

run("configuring" ${CMAKE_COMMAND} -S ${SOURCE} -B ${SCRATCH}/build -G Ninja -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_CXX_COMPILER=${COMPILER} -D CMAKE_PREFIX_PATH=${SCRATCH}/prefix -D CARAT_WANTED=${VERSION})
run("building" ${CMAKE_COMMAND} --build ${SCRATCH}/build)
run("running the consumer" ${SCRATCH}/build/consumer ${file} ${place} ${height})
