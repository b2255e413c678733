# The free slider-crank, flexible and rigid: its coupler, and what its guide carries (Figs. 10 and 11 of the paper). Drawn from the files of
#   for m in slider_crank_flexible_free slider_crank_rigid_free; do for s in cartesian relative; do
#     compare/run run data/models/$m.toml --solver $s --until 0.1 --samples 400 --out results; done; done
#   cd results && gnuplot ../data/references/slider_crank_free.gp
set terminal svg size 900,1300 font "Helvetica,13" background "white"
set output "slider_crank_free.svg"
set datafile separator ","
set multiplot layout 5,1 margins 0.11,0.98,0.05,0.95 spacing 0.05
set grid lc rgb "#dddddd"
set xrange [0:0.1]
set key at screen 0.98,0.99 right top horizontal
set format x ""
flexible = "slider_crank_flexible_free"
rigid = "slider_crank_rigid_free"
spin = "coupler.omegadot_z [rad/s2]"
set ylabel "rad/s^2"
set label 1 "angular acceleration of the coupler about z" at graph 0.0,1.07
plot flexible.".cartesian.motion.csv" using 1:(column(spin)) with lines lw 1.2 lc rgb "#1b6ca8" title "flexible, cartesian", \
     flexible.".relative.motion.csv" using 1:(column(spin)) every 4 with points pt 7 ps 0.35 lc rgb "#d1495b" title "flexible, relative", \
     rigid.".cartesian.motion.csv" using 1:(column(spin)) with lines lw 2 lc rgb "#333333" title "rigid"
set ylabel "N"
do for [axis in "x y"] {
  force = "B.child.F_".axis." [N]"
  set label 1 "reaction at B on the coupler, ".(axis eq "x" ? "along it, F_x" : "across it, F_y")
  plot flexible.".cartesian.reactions.csv" using 1:(column(force)) with lines lw 1.2 lc rgb "#1b6ca8" notitle, \
       flexible.".relative.reactions.csv" using 1:(column(force)) every 4 with points pt 7 ps 0.35 lc rgb "#d1495b" notitle, \
       rigid.".cartesian.reactions.csv" using 1:(column(force)) with lines lw 2 lc rgb "#333333" notitle
}
# In the axes of the guide, whose z is the slide: F_x across it and T_y out of the plane are F_y and T_z of the paper.
do for [component in "F_x T_y"] {
  set ylabel component eq "F_x" ? "N" : "N m"
  on_ground = "D.parent.".component.(component eq "F_x" ? " [N]" : " [N m]")
  on_slider = "D.child.".component.(component eq "F_x" ? " [N]" : " [N m]")
  set label 1 "reaction in the guide D, ".(component eq "F_x" ? "across it" : "torque out of the plane").", on the slider and, pale, on the ground"
  if (component eq "T_y") { set format x "%g"; set xlabel "t [s]" offset 0,0.5 }
  plot flexible.".cartesian.reactions.csv" using 1:(column(on_ground)) with lines lw 1.2 lc rgb "#a9cbe6" notitle, \
       rigid.".cartesian.reactions.csv" using 1:(column(on_ground)) with lines lw 2 lc rgb "#aaaaaa" notitle, \
       flexible.".cartesian.reactions.csv" using 1:(column(on_slider)) with lines lw 1.2 lc rgb "#1b6ca8" notitle, \
       flexible.".relative.reactions.csv" using 1:(column(on_slider)) every 4 with points pt 7 ps 0.35 lc rgb "#d1495b" notitle, \
       rigid.".cartesian.reactions.csv" using 1:(column(on_slider)) with lines lw 2 lc rgb "#333333" notitle
}
unset multiplot
