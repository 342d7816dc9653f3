function [scene, as_created] = chart_scene()
% The ColorChecker under D65: patches of 32 x 32 pixels, 10 degrees wide, at 1.2 m, with a mean luminance of 75 cd/m2.
as_created = sceneCreate('macbeth d65', 32);
scene = sceneSet(sceneSet(as_created, 'fov', 10), 'distance', 1.2);
scene = sceneAdjustLuminance(scene, 75);
end
