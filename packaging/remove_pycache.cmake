# Run by cpack between installing and packing: catkin installs compiled Python, which a Debian package must not hold.
file(GLOB_RECURSE compiled ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*.pyc)
foreach(file IN LISTS compiled)
  get_filename_component(folder ${file} DIRECTORY)
  file(REMOVE ${file})
  if(folder MATCHES "/__pycache__$")
    file(REMOVE_RECURSE ${folder})
  endif()
endforeach()
