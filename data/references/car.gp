# The car over the bump: what answers to the paper's Figs. 14 to 16. Drawn from the files of
#   for s in cartesian relative; do
#     compare/run run data/models/car.toml --solver $s --rtol 1e-9 --samples 4000 --out results; done
#   cd results && gnuplot ../data/references/car.gp
set terminal svg size 900,1150 font "Helvetica,13" background "white"
set output "car.svg"
set datafile separator ","
set multiplot layout 4,1 margins 0.11,0.97,0.06,0.94 spacing 0.065
set grid lc rgb "#dddddd"
set xrange [5.9:7.4]
set key at screen 0.98,0.995 right top horizontal
set format x ""
one = "car.cartesian."
other = "car.relative."
rise = "chassis.vdot_z [m/s2]"
set ylabel "m/s^2"
set label 1 "vertical acceleration of the chassis" at graph 0.0,1.07
plot one."motion.csv" using 1:(column(rise)) with lines lw 1.4 lc rgb "#333333" title "cartesian", \
     other."motion.csv" using 1:(column(rise)) every 4 with points pt 7 ps 0.3 lc rgb "#d1495b" title "relative"
strut(side, what) = "front_left_strut.".side.".".what
set ylabel "N"
set label 1 "left strut on the knuckle: reaction along x, y, z of the joint (z slides), and the total along z"
set key at graph 0.99,0.72 right top vertical
plot one."reactions.csv" using 1:(column(strut("child", "F_x [N]"))) with lines lw 1.4 lc rgb "#1b6ca8" title "F_x", \
     one."reactions.csv" using 1:(column(strut("child", "F_y [N]"))) with lines lw 1.4 lc rgb "#3c8d40" title "F_y", \
     one."reactions.csv" using 1:(column(strut("child", "F_z [N]"))) with lines lw 1.4 lc rgb "#888888" title "F_z", \
     one."reactions.csv" using 1:(column("front_left_strut.tau_1 [N]")) with lines lw 1.4 lc rgb "#c97b12" title "total F_z: spring and damper", \
     other."reactions.csv" using 1:(column(strut("child", "F_x [N]"))) every 4 with points pt 7 ps 0.25 lc rgb "#d1495b" notitle, \
     other."reactions.csv" using 1:(column(strut("child", "F_y [N]"))) every 4 with points pt 7 ps 0.25 lc rgb "#d1495b" notitle, \
     other."reactions.csv" using 1:(column("front_left_strut.tau_1 [N]")) every 4 with points pt 7 ps 0.25 lc rgb "#d1495b" notitle
set ylabel "N m"
do for [side in "child parent"] {
  set label 1 "left strut: torque on the ".(side eq "child" ? "knuckle" : "strut").", at the joint point of its side"
  if (side eq "parent") { set format x "%g"; set xlabel "t [s]" offset 0,0.5 }
  plot one."reactions.csv" using 1:(column(strut(side, "T_x [N m]"))) with lines lw 1.4 lc rgb "#1b6ca8" title "T_x", \
       one."reactions.csv" using 1:(column(strut(side, "T_y [N m]"))) with lines lw 1.4 lc rgb "#3c8d40" title "T_y", \
       one."reactions.csv" using 1:(column(strut(side, "T_z [N m]"))) with lines lw 1.4 lc rgb "#888888" title "T_z", \
       other."reactions.csv" using 1:(column(strut(side, "T_x [N m]"))) every 4 with points pt 7 ps 0.25 lc rgb "#d1495b" notitle, \
       other."reactions.csv" using 1:(column(strut(side, "T_y [N m]"))) every 4 with points pt 7 ps 0.25 lc rgb "#d1495b" notitle
}
unset multiplot
