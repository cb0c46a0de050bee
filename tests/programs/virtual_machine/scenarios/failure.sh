# A scenario that fails is told from one that passes.
echo "about to fail"
exit 3
