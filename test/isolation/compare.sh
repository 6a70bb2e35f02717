#!/bin/sh
# compare.sh PROGRAM PROGRAM RESULT.xml: both must print the same line, which must not be empty.
first=$("$1") && second=$("$2") && [ -n "$first" ] && [ "$first" = "$second" ]
status=$?
echo "$first $second"
if [ $status -eq 0 ]; then failure=""; else failure="<failure message=\"$first is not $second\"/>"; fi
mkdir -p "$(dirname "$3")"
printf '<testsuite name="isolation"><testcase classname="isolation" name="hooks_change_nothing">%s</testcase></testsuite>\n' \
  "$failure" >"$3"
exit $status
