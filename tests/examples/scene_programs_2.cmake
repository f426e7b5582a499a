# What the programs charges, lattice and vortices do with effects; CMakeLists.txt includes this file.

foreach(program IN ITEMS charges lattice vortices)
  check(${program} "lists its effects" "--list-effects" ABSENT out)
  check(${program} "lists its presets" "--list-presets" ABSENT out)
  refuses(${program} "an unknown effect" "--effects disc" "--effects: no effect is called 'disc'; the nearest names are [a-z]")
  refuses(${program} "an unknown preset" "--preset walk" "--preset: no preset is called 'walk'; the nearest names are [a-z]")
  refuses(${program} "an audit and a cost" "--audit --cost" "excludes")
  refuses(${program} "an audit by another method" "--audit --method gauss" "--method means nothing to --audit")
  refuses(${program} "an audit into a folder" "--audit --output out" "--output means nothing to --audit")
endforeach()
foreach(program IN ITEMS charges lattice)
  refuses(${program} "a step longer than the time" "--dt 2 --time 1" "--dt is larger than --time")
endforeach()

# Closed forms: the figures that the programs print of themselves.
check(charges "gyrates at eB/m" "--no-plot" FILE out/charges.csv HEADER "t,energy_error,defect"
  PRINTS "gyrofrequency, rad/s: 9578833.2; eB/m: 9578833.2 .*gyroradius, m: 0.0449997[0-9]+; mv/.eB.: 0.0449997")
check(charges "is thrown back by a bottle" "--preset bottle --time 4e-5s --no-plot"
  FILE out/charges_trajectory.csv HEADER "t,x,y,z,px,py,pz"
  PRINTS "turning point, m: 0.5773[0-9]+( ± [1-9]e-0[89])?; .*bounce period, s: 1.6575[0-9]+e-05; .*1.6575")
check(charges "says why it measures nothing" "--preset bottle --b0 1G --no-plot" FILE out/charges.csv
  PRINTS "turning point and bounce period: not measured, the run has no whole bounce")
check(charges "reads small units" "--b \"1e8 nT\" --energy 1e-3MeV --no-plot" FILE out/charges.csv PRINTS "eB/m: 9578833.2 ")
check(charges "bounces and drifts about the Earth" "--preset dipole --no-plot" FILE out/charges.csv
  PRINTS "bounce period, s: 2.3[0-9]+; .*e-03.\n.*drift period, s .westward: negative.: -77.[0-9] ± 0.[0-9]; adiabatic: -78.[0-9]+")
check(charges "moves without kinetic in a field" "--preset bottle --effects magnetic_bottle,coulomb --time 1e-6s --no-plot"
  FILE out/charges.csv PRINTS "effects: magnetic_bottle, coulomb\ncoupled by magnetic_bottle: not separable")
check(charges "doubles nothing without a magnetic field" "--effects kinetic,electric --no-plot"
  FILE out/charges.csv HEADER "t,energy_error" PRINTS "separable: plain explicit splitting, no doubling")
check(charges "audits its effects" "--audit --time 1e-6s" ABSENT out PRINTS "called for at 1e-02: kinetic, uniform_field\n")
refuses(charges "a charge that cannot move" "--effects electric" "nothing moves without kinetic or a magnetic field")
refuses(charges "a speed that needs relativity" "--energy \"10000 MeV\"" "a speed of 4[.]6 c, where Newton's equations are off")
refuses(charges "an unknown unit" "--b 1Tesla" "--b: no unit is called 'Tesla'; the nearest names are")
refuses(charges "a unit of another kind" "--b 1V" "'1V' is a")

# The same figures to the last digit shown, as long as rounding has not grown: the motion is chaotic.
foreach(program IN ITEMS nls lattice)
  check(${program} "has the errors of the paper's lattice" "--time 5 --no-plot" FILE out/${program}.csv
    HEADER "t,energy_error,mass_error,defect" PRINTS "energy error, worst +7.4e-11\nenergy error, final +1.5e-11")
endforeach()
check(lattice "localises" "--preset anderson --no-plot" FILE out/lattice.csv HEADER "t,energy_error,mass_error"
  PRINTS "separable: plain explicit splitting.*participation number at the end: 8.42044[0-9]* ± [1-9]e-0[78]; of 128 sites; largest difference of a density from [^\n]*: [0-9.]+e-09; by these: 8.42044")
check(lattice "traps on two sites as in closed form" "--preset dnls --sites 2 --time 20 --dt 0.005 --no-plot" FILE out/lattice_trajectory.csv
  HEADER "t,density0,density1" PRINTS "at least: 0.72906[0-9]*[^\n]*; in closed form: 0.72906[0-9]* .relative difference [0-9.]+e-1[0-9]")
check(lattice "measures nothing at the threshold" "--preset dnls --sites 2 --g 4 --dt 0.002 --no-plot" FILE out/lattice.csv
  PRINTS "at least: not measured, g.* = 4 is the threshold, where rounding decides" LACKS "in closed form")
check(lattice "lets go below the threshold" "--preset dnls --sites 2 --g 3.9 --time 20 --dt 0.005 --no-plot" FILE out/lattice.csv
  PRINTS "at least: [0-9.]+e-[0-9]+ ± [1-9]e-0[67][^\n]*; in closed form: 0 ")
by_shell(lattice "scales its colours with the mass" "$program --preset anderson --mass 1e-9 --time 1 && grep 'cbrange .1e-15:' out/lattice.gp")
by_shell(lattice "draws one site by a line" "$program --preset anderson --sites 1 --effects disorder --time 5 && grep 'using 1:2 with lines' out/lattice.gp && ! grep 'with image' out/lattice.gp")
by_shell(lattice "says where rows hide beats" "$program --preset dnls --sites 2 --g 0.001 --time 3150 && grep 'farther apart than beats' out/lattice.gp && $program --preset dnls --sites 2 --g 0.001 --time 300 --output slow && ! grep 'farther apart' slow/lattice.gp")
refuses(lattice "half a site" "--sites 2.5" "--sites: '2.5' is not a whole number from 1")

check(vortices "draw apart before a wall" "--preset wall --no-plot" FILE out/vortices.csv
  HEADER "t,energy_error,impulse_y_error,defect" PRINTS "speed along the wall at the end: 0.080292[0-9]+ ± [1-9]e-(09|10); .*: 0.080292")
check(vortices "are strained along a wall" "--preset wall --effects pairs,half_plane,strain --strain_rate 1e-3 --strain_angle \"180 deg\" --time 1 --no-plot" FILE out/vortices.csv)
refuses(vortices "a strain through a wall" "--preset wall --effects pairs,half_plane,strain --strain_rate 1e-3 --strain_angle \"45 deg\"" "only strain with --strain_angle 0 or .90 deg. flows along")
check(vortices "turn in a disk" "--preset disk --no-plot" FILE out/vortices.csv
  HEADER "t,energy_error,angular_impulse_error,defect" PRINTS "turns at: 0.21220659; .*: 0.21220659")
check(vortices "are strained" "--effects pairs,strain --strain_angle 45deg --time 10 --no-plot" FILE out/vortices.csv
  HEADER "t,energy_error,defect" PRINTS "coupled by pairs, strain")
check(vortices "double nothing in a rotation" "--effects rotation --time 10 --no-plot" FILE out/vortices.csv
  HEADER "t,energy_error,angular_impulse_error" PRINTS "separable: plain explicit splitting, no doubling")
# Against runs of another integrator with one field alone, from the same canonical momentum: 0.257 and 5.8e-04.
check(charges "leaves out a field that another counts as there" "--preset dipole --effects kinetic,dipole_field,uniform_field --time 10s --audit"
  PRINTS "uniform_field +[0-9.]+% +[^ ]+ +[^ ]+ +[^ ]+ +2[.]6e-01 ")
check(fast_charges "leaves out a field that another counts as there" "--preset solenoid --effects kinetic,solenoid,uniform_field --b 50mT --audit"
  PRINTS "uniform_field +[0-9.]+% +[^ ]+ +[^ ]+ +[^ ]+ +5[.]8e-04 ")
check(charges "leaves out a field where there is no motion but in fields" "--preset dipole --effects dipole_field,uniform_field --b 1e-13T --time 2s --audit"
  PRINTS "called for at 1e-02: dipole_field\n.*one field at least stays\n")
check(vortices "audit their effects" "--audit --time 20" ABSENT out PRINTS "called for at 1e-10: pairs, strain, rotation\n")
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/vortices.toml "preset = \"wall\"\neffects = [\"pairs\", \"half_plane\"]\ntime = 5\nno-plot = true\n")
check(vortices "read a configuration" "--config ${CMAKE_CURRENT_BINARY_DIR}/vortices.toml" FILE out/vortices.csv ABSENT out/vortices.png
  PRINTS "effects: pairs, half_plane\n")
refuses(vortices "a vortex behind the wall" "--effects pairs,half_plane" "vortex 0 is on the dry side of half_plane")
refuses(vortices "two walls" "--preset wall --effects pairs,half_plane,disk --radius 9" "half_plane and disk are two flows")
refuses(vortices "strain in a disk" "--effects pairs,strain,disk" "strain flows through the wall of disk")
refuses(vortices "rotation at a straight wall" "--preset wall --effects pairs,rotation,half_plane --rotation_rate 1" "only strain with --strain_angle 0")
refuses(vortices "a disk without a radius" "--input ${CMAKE_CURRENT_SOURCE_DIR}/pair.csv --effects pairs,disk" "no value for --radius; give one")
refuses(vortices "a file and a preset" "--input pair.csv --preset disk" "excludes")

# Charges at nearly the speed of light, beside the formulas that the program prints.
check(fast_charges "lists its effects" "--list-effects" ABSENT out)
check(fast_charges "lists its presets" "--list-presets" ABSENT out)
check(fast_charges "gyrates at eB/gm" "--no-plot" FILE out/fast_charges.csv HEADER "t,energy_error,defect"
  PRINTS "gyrofrequency.*difference [0-9.]+e-1[0-9].*gyroradius.*difference [0-9.]+e-1[0-9]")
check(fast_charges "wiggles in an undulator" "--preset undulator --no-plot" FILE out/fast_charges_trajectory.csv HEADER "t,x,y,z,px,py,pz"
  PRINTS "wiggle.*difference [0-9.]+e-04.*slippage.*difference [0-9.]+e-04")
check(fast_charges "is turned by a solenoid" "--preset solenoid --no-plot" PRINTS "Larmor.*difference [0-9.]+e-0[67]")
check(fast_charges "is focused by a quadrupole" "--preset quadrupole --no-plot" PRINTS "x at the end.*e-0[67].\n.*y at the end.*e-0[67].\n")
check(fast_charges "stays out of Stoermer's region" "--preset cosmic_ray --no-plot" PRINTS "way: 0[.]999[0-9] ± 0[.]000[1-4]; forbidden: above 1\nnearest to the dipole, Earth radius: 0[.]8830 ± 0[.]000[1-4]\n")
check(fast_charges "audits its effects" "--audit --preset solenoid" ABSENT out PRINTS "called for at 1e-04: kinetic, solenoid")
refuses(fast_charges "a charge that cannot move" "--effects electric" "nothing moves without kinetic or a magnetic field")
refuses(fast_charges "a gamma below one" "--gamma 0.5" "--gamma: '0.5' is not a number above 1")
